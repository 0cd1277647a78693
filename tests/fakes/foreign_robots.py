"""Robots after the habits of public descriptions: hubs, tyres beside joints, controllers, SDF."""

import math
from dataclasses import dataclass
from pathlib import Path

from tests.fakes.own_robots import (
    CHASSIS,
    LIMITS,
    PI,
    Own,
    box,
    caster,
    cylinder,
    inertial,
    joint,
    lidar,
    link,
    pair,
    robot,
    wheel,
)
from tests.fakes.robots import PACKAGES

ACCELERATIONS = "acc_lim_x: 1.0\nacc_lim_theta: 2.0\n"
CONTROL = (
    '<gazebo><plugin filename="gz_ros2_control-system" '
    'name="gz_ros2_control::GazeboSimROS2ControlPlugin"><parameters>{}</parameters></plugin>'
    "</gazebo>"
)
CORNERS = (
    ("front_left", 0.15, 0.17), ("front_right", 0.15, -0.17),
    ("rear_left", -0.15, 0.17), ("rear_right", -0.15, -0.17),
)  # fmt: skip


def solid(shape: str, y: float = 0.0) -> str:
    origin = f'<origin xyz="0 {y:.9g} 0" rpy="{PI / 2:.9g} 0 0"/>'
    return f"<collision>{origin}<geometry>{shape}</geometry></collision>"


def made_wheel(name: str, place: tuple[float, float, float], *solids: str, limit: str = "") -> str:
    """A wheel of several shapes."""
    body = f'<link name="{name}_wheel">{inertial(0.5, 1e-3)}{"".join(solids)}</link>'
    turn = joint(f"{name}_wheel_joint", "base_link", f"{name}_wheel", place, kind="continuous")
    return body + turn.replace("</joint>", f"{limit}</joint>")


def two_wheels(*parts: str, name: str = "rover", settings: str = LIMITS, **files: str) -> Own:
    """A chassis with casters in front and behind, and a LiDAR."""
    body = [CHASSIS, caster("ball_0", 0.16), caster("ball_1", -0.16)]
    return Own(robot(name, [*body, *parts, lidar()]), settings, files)


def hub_first() -> Own:
    """A hub that is listed before the tyre, as wide as it."""
    shapes = solid(cylinder(0.03, 0.06)), solid(cylinder(0.08, 0.04))
    wheels = [made_wheel(s, (0.0, y, 0.08), *shapes) for s, y in (("left", 0.2), ("right", -0.2))]
    return two_wheels(*wheels, name="hubs")


def inboard_tyres() -> Own:
    """Joints outside of the tyres: 0.4476 m apart, and the tyres 0.358 m."""
    wheels = [
        made_wheel(
            side, (0.0, sign * 0.2238, 0.0625), solid(cylinder(0.0625, 0.05), -sign * 0.0448)
        )
        for side, sign in (("left", 1.0), ("right", -1.0))
    ]
    return two_wheels(*wheels, name="inboard")


def four_wheels(*parts: str, name: str = "four", settings: str = LIMITS, **files: str) -> Own:
    """Four wheels at the corners."""
    wheels = [wheel(place, (x, y, 0.05)) for place, x, y in CORNERS]
    return Own(robot(name, [CHASSIS, *wheels, *parts, lidar(xyz=(0.1, 0.0, 0.2))]), settings, files)


MECANUM = (PACKAGES / "controllers/mecanum.yaml").read_text(encoding="utf-8")
DIFFERENTIAL = (PACKAGES / "controllers/differential.yaml").read_text(encoding="utf-8")


def mecanum_by_controller() -> Own:
    """The file of ros2_control is the only word on the drive."""
    return four_wheels(CONTROL.format("mec.yaml"), name="mec", **{"mec.yaml": MECANUM})


def limits_by_controller() -> Own:
    """The file of ros2_control has drive and limits."""
    plugin = CONTROL.format("config.yaml")
    files = {"config.yaml": DIFFERENTIAL}
    return two_wheels(*pair(), plugin, name="controlled", settings="model: ctl\n", **files)


def plugin_drive() -> Own:
    """Gazebo Sim's plugin has drive, joints and limits."""
    plugin = (
        '<gazebo><plugin filename="gz-sim-diff-drive-system" '
        'name="gz::sim::systems::DiffDrive"><left_joint>left_wheel_joint</left_joint>'
        "<right_joint>right_wheel_joint</right_joint><wheel_separation>0.3</wheel_separation>"
        "<wheel_radius>0.05</wheel_radius><max_linear_velocity>0.5</max_linear_velocity>"
        "<max_angular_velocity>1.5</max_angular_velocity><max_linear_acceleration>1.0"
        "</max_linear_acceleration><max_angular_acceleration>2</max_angular_acceleration>"
        "<topic>cmd_vel</topic></plugin></gazebo>"
    )
    return two_wheels(*pair(), plugin, name="omnicorp_controller_freebot", settings="model: p\n")


def placeholder() -> Own:
    """A limit of 100 rad/s, which nobody measured; robot.yaml has the speeds."""
    return two_wheels(*fast_wheels(), name="fast", settings=LIMITS)


def fast_wheels(limit: float = 100.0) -> list[str]:
    text = f'<limit effort="100" velocity="{limit:g}"/>'
    return [
        made_wheel(side, (0.0, y, 0.05), solid(cylinder(0.05, 0.03)), limit=text)
        for side, y in (("left", 0.15), ("right", -0.15))
    ]


def rear_first() -> Own:
    """Two equal LiDARs, the rear one first."""
    wide = 2.35
    rear = lidar("rear", (-0.19, 0.0, 0.17), f"0 0 {PI}", rays=270, first=-wide, last=wide)
    front = lidar("front", (0.19, 0.0, 0.17), rays=270, first=-wide, last=wide)
    body = [CHASSIS, caster("ball_0", 0.16), caster("ball_1", -0.16), *pair()]
    return Own(robot("rearfirst", [*body, rear, front]))


SDF = (PACKAGES / "tb/model.sdf").read_text(encoding="utf-8")
CONFIG = (PACKAGES / "tb/model.config").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Folder:
    """A model's folder as Gazebo has it."""

    sdf: str = SDF

    def write(self, folder: Path) -> Path:
        folder = folder / "tb"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "model.sdf").write_text(self.sdf, encoding="utf-8")
        (folder / "model.config").write_text(CONFIG, encoding="utf-8")
        return folder


def wheel_of_rollers(name: str, x: float, y: float) -> str:
    """A wheel whose tread is eight rollers on joints of their own."""
    parts = [made_wheel(name, (x, y, 0.05), solid(cylinder(0.035, 0.03)))]
    for k in range(8):
        angle = 2.0 * math.pi * k / 8.0
        place = (0.04 * math.sin(angle), 0.0, 0.04 * math.cos(angle))
        parts.append(link(f"{name}_r{k}", cylinder(0.01, 0.02), inertial(0.01, 1e-6)))
        turn = joint(f"{name}_r{k}_joint", f"{name}_wheel", f"{name}_r{k}", place,
                     f"0 {angle:.9g} 0.785398", "continuous", "1 0 0")  # fmt: skip
        parts.append(turn)
    return "".join(parts)


def on_rollers() -> Own:
    """Mecanum wheels that nothing but their rollers shows."""
    body = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 0.08), xyz="0 0 0.12")
    wheels = [wheel_of_rollers(place, x, y) for place, x, y in CORNERS]
    return Own(robot("plain", [body, *wheels, lidar(xyz=(0.1, 0.0, 0.2))]))


FOREIGN = {
    "differential by plugin": plugin_drive,
    "hub first": hub_first,
    "tyres beside their joints": inboard_tyres,
    "mecanum by controller": mecanum_by_controller,
    "limits by controller": limits_by_controller,
    "rear LiDAR first": rear_first,
    "placeholder limit": placeholder,
    "SDF": Folder,
    "wheels with rollers": on_rollers,
}
