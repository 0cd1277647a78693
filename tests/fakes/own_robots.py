"""Robots of our own making, each with a trait that descriptions of real robots have."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

PI = math.pi
LIMITS = "max_vel_x: 0.5\nmax_vel_theta: 1.5\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"


def box(x: float, y: float, z: float) -> str:
    return f'<box size="{x:.9g} {y:.9g} {z:.9g}"/>'


def cylinder(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius:.9g}" length="{length:.9g}"/>'


def ball(radius: float) -> str:
    return f'<sphere radius="{radius:.9g}"/>'


def inertial(mass: float, inertia: float, xyz: str = "0 0 0") -> str:
    return (
        f'<inertial><origin xyz="{xyz}"/><mass value="{mass:.9g}"/><inertia ixx="{inertia:.9g}" '
        f'ixy="0" ixz="0" iyy="{inertia:.9g}" iyz="0" izz="{inertia:.9g}"/></inertial>'
    )


def link(name: str, shape: str = "", mass: str = "", xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    solid = f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}</geometry></collision>'
    return f'<link name="{name}">{mass}{solid if shape else ""}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rpy: str = "0 0 0",
    kind: str = "fixed",
    axis: str = "0 1 0",
) -> str:
    x, y, z = xyz
    turn = f'<axis xyz="{axis}"/>' if kind != "fixed" else ""
    limit = '<limit lower="-0.6" upper="0.6" effort="9" velocity="9"/>'
    limit = limit if kind == "revolute" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x:.9g} {y:.9g} {z:.9g}" rpy="{rpy}"/>{turn}{limit}</joint>'
    )


def wheel(
    name: str,
    xyz: tuple[float, float, float],
    radius: float = 0.05,
    parent: str = "base_link",
    mass: str = "",
    kind: str = "continuous",
) -> str:
    mass = mass or inertial(0.3, 4e-4)
    body = link(f"{name}_wheel", cylinder(radius, 0.03), mass, rpy=f"{PI / 2} 0 0")
    return body + joint(f"{name}_wheel_joint", parent, f"{name}_wheel", xyz, kind=kind)


def ray_sensor(
    reference: str,
    rays: int = 360,
    far: float = 8.0,
    first: float = -PI,
    last: float = PI,
    pose: str = "",
    layers: int = 1,
) -> str:
    placed = f"<pose>{pose}</pose>" if pose else ""
    return (
        f'<gazebo reference="{reference}"><sensor name="{reference}_rays" type="gpu_lidar">{placed}'
        f"<update_rate>10</update_rate><lidar><scan><horizontal><samples>{rays}</samples>"
        f"<min_angle>{first}</min_angle><max_angle>{last}</max_angle></horizontal>"
        f"<vertical><samples>{layers}</samples></vertical></scan>"
        f"<range><min>0.1</min><max>{far}</max></range></lidar></sensor></gazebo>"
    )


def lidar(
    name: str = "laser",
    xyz: tuple[float, float, float] = (0.1, 0.0, 0.16),
    rpy: str = "0 0 0",
    parent: str = "base_link",
    **scan: object,
) -> str:
    place = link(name) + joint(f"{name}_joint", parent, name, xyz, rpy)
    return place + ray_sensor(name, **scan)


def robot(name: str, parts: Iterable[str]) -> str:
    return f'<?xml version="1.0"?>\n<robot name="{name}">' + "\n".join(parts) + "</robot>\n"


CHASSIS = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 0.08), xyz="0 0 0.1")


def pair(z: float = 0.05, y: float = 0.15, x: float = 0.0, radius: float = 0.05) -> list[str]:
    """Two wheels on an axle; base_link lies on the ground."""
    return [wheel("left", (x, y, z), radius), wheel("right", (x, -y, z), radius)]


def caster(name: str, x: float, y: float = 0.0, below: float = 0.0, radius: float = 0.02) -> str:
    """A ball that reaches `below` [m] under the ground."""
    body = link(name, ball(radius), inertial(0.05, 1e-5))
    return body + joint(f"{name}_joint", "base_link", name, (x, y, radius - below))


@dataclass(frozen=True)
class Own:
    """A description and its robot.yaml."""

    urdf: str
    settings: str = LIMITS
    files: dict[str, str] = field(default_factory=dict)

    def write(self, folder: Path, name: str = "own") -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.urdf"
        path.write_text(self.urdf, encoding="utf-8")
        (folder / f"{name}.robot.yaml").write_text(self.settings, encoding="utf-8")
        for file, text in self.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        return path


def sprung(below: float, xs: tuple[float, ...] = (-0.15,)) -> Own:
    """A two-wheeled robot with casters on springs, drawn relaxed."""
    casters = [caster(f"caster_{i}", x, below=below) for i, x in enumerate(xs)]
    return Own(robot("sprung", [CHASSIS, *pair(), *casters, lidar()]))


def lifted(height: float) -> Own:
    """Wheels that end above the ground of base_footprint, and casters that are no balls."""
    footprint = link("base_footprint") + joint("base_joint", "base_footprint", "base_link")
    return Own(robot("lifted", [footprint, CHASSIS, *pair(0.05 + height), lidar()]))


def slanting(off: float) -> Own:
    """One wheel higher than the other."""
    wheels = [wheel("left", (0.0, 0.15, 0.05 + off)), wheel("right", (0.0, -0.15, 0.05))]
    named = "wheels: {left: [left_wheel_joint], right: [right_wheel_joint]}\n"
    text = robot("slanting", [CHASSIS, *wheels, caster("caster", -0.15), lidar()])
    return Own(text, LIMITS + named)


TRAITS: dict[str, Callable[[], Own]] = {
    "caster 2 mm low": lambda: sprung(0.002),
    "casters 2 mm low": lambda: sprung(0.002, (0.16, -0.16)),
    "caster 8 mm low": lambda: sprung(0.008),
    "wheels 0.2 mm high": lambda: lifted(0.0002),
    "wheels 4 mm high": lambda: lifted(0.004),
    "wheels 4 mm low": lambda: lifted(-0.004),
    "one wheel 3 mm high": lambda: slanting(0.003),
}


def hanging() -> Own:
    """A LiDAR under the top plate, upside down and turned."""
    laser = lidar(xyz=(0.12, 0.0, 0.2), rpy=f"{PI} 0 0.7")
    return Own(robot("hanging", [CHASSIS, *pair(), caster("caster", -0.15), laser]))


def with_cliff_sensors() -> Own:
    """Sensors that look at the floor, and range finders, before the LiDAR."""
    cliffs = [
        lidar(f"cliff_{k}", (0.19, y, 0.05), f"0 {PI / 2} 0", rays=1, far=0.15, first=0.0, last=0.0)
        for k, y in enumerate((-0.1, 0.0, 0.1))
    ]
    finders = [
        lidar(f"range_{k}", (0.2, y, 0.1), f"0 0 {y}", rays=5, far=0.9, first=-0.2, last=0.2)
        for k, y in enumerate((-0.1, 0.1))
    ]
    sensors = [*cliffs, *finders, lidar("laser", (0.0, 0.0, 0.2), rays=480, far=10.0)]
    return Own(robot("cliffs", [CHASSIS, *pair(), caster("caster", -0.15), *sensors]))


def two_scanners() -> Own:
    """Safety scanners on opposite corners, each with its view of 270 degrees."""
    wide = 3 * PI / 2
    front = lidar("front_laser", (0.2, 0.13, 0.17), f"0 0 {PI / 4}", first=-wide / 2, last=wide / 2)
    back = lidar("back_laser", (-0.2, -0.13, 0.17), f"0 0 {-3 * PI / 4}", far=7.9)
    casters = [caster(f"caster_{k}", x, y) for k, (x, y) in enumerate(CORNERS)]
    return Own(robot("scanners", [CHASSIS, *pair(), *casters, front, back]))


CORNERS = ((0.15, 0.1), (0.15, -0.1), (-0.15, 0.1), (-0.15, -0.1))


def own_footprint_joint() -> Own:
    """base_link is the root, and base_footprint hangs below it on a joint of that name."""
    body = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 0.08), xyz="0 0 0.05")
    low = link("base_footprint") + joint(
        "base_footprint_joint", "base_link", "base_footprint", (0.0, 0.0, -0.05)
    )
    ball_link = link("caster", ball(0.02), inertial(0.05, 1e-5))
    ball_joint = joint("caster_joint", "base_link", "caster", (-0.15, 0.0, -0.03))
    parts = [low, body, *pair(0.0), ball_link, ball_joint, lidar(xyz=(0.1, 0.0, 0.15))]
    return Own(robot("footprint_joint", parts))


def planar_move(turning: bool = False) -> Own:
    """A round robot on three omnidirectional wheels that do not turn; a plugin moves the body."""
    body = link("base_link", cylinder(0.2, 0.2), inertial(12.0, 0.2), xyz="0 0 0.13")
    wheels = []
    for k in range(3):
        angle = 2.0 * PI * k / 3.0
        place = (0.16 * math.cos(angle), 0.16 * math.sin(angle), 0.06)
        kind = "continuous" if turning else "fixed"
        shape = cylinder(0.06, 0.03)
        wheels.append(link(f"wheel_{k}", shape, inertial(0.4, 1e-3), rpy=f"0 {PI / 2} 0"))
        wheels.append(
            joint(
                f"wheel_{k}_joint", "base_link", f"wheel_{k}", place, f"0 0 {angle}", kind, "1 0 0"
            )
        )
    plugin = (
        '<gazebo><plugin name="move" filename="libgazebo_ros_planar_move.so">'
        "<robot_base_frame>base_link</robot_base_frame></plugin></gazebo>"
    )
    settings = LIMITS + "max_vel_y: 0.4\n"
    return Own(robot("planar", [body, *wheels, plugin, lidar(xyz=(0.1, 0.0, 0.25))]), settings)


def mecanum_that_is_moved() -> Own:
    """Four mecanum wheels that turn, and a plugin that moves the body all the same."""
    names = ("front_left", "front_right", "rear_left", "rear_right")
    places = ((0.15, 0.17), (0.15, -0.17), (-0.15, 0.17), (-0.15, -0.17))
    wheels = [wheel(n, (x, y, 0.05)) for n, (x, y) in zip(names, places, strict=True)]
    plugin = '<gazebo><plugin name="v" filename="gz-sim-velocity-control-system"/></gazebo>'
    return Own(robot("ridge", [CHASSIS, *wheels, plugin, lidar()]))


def many_sided() -> Own:
    """A body whose outline has to be simplified and rounded."""
    shapes = [
        link("base_link", cylinder(0.2000371, 0.1), inertial(6.0, 0.08), xyz="0 0 0.1"),
        link("plate", box(0.2831, 0.2832, 0.02), xyz="0.0003 0.0001 0", rpy="0 0 0.7853"),
        joint("plate_joint", "base_link", "plate", (0.00005, 0.0, 0.16)),
    ]
    return Own(robot("many", [*shapes, *pair(y=0.13), caster("c", -0.15), lidar(xyz=(0, 0, 0.2))]))


def dropping_wheels() -> Own:
    """A vacuum cleaner's base: wheels on springs, a rigid caster, base_link at the axle."""
    body = link("base_link", cylinder(0.164, 0.06), inertial(2.3, 0.015), xyz="0 0 0.02")
    wheels = []
    for side, y in (("left", 0.1165), ("right", -0.1165)):
        drop = joint(f"{side}_drop_joint", "base_link", f"{side}_drop", (0, y, 0), kind="prismatic")
        wheels += [link(f"{side}_drop"), drop, wheel(side, (0, 0, 0.0), 0.036, f"{side}_drop")]
    roller = link("caster", ball(0.011), inertial(0.02, 1e-6))
    under = joint("caster_joint", "base_link", "caster", (0.125, 0.0, -0.0255))
    tower = lidar("rplidar_link", (-0.04, 0.0, 0.1), f"0 0 {PI / 2}", rays=640, far=12.0)
    cliff = lidar("cliff_front", (0.15, 0.0, 0.0), f"0 {PI / 2} 0", rays=1, far=0.1)
    bottom = link("base_footprint") + joint(
        "base_footprint_joint", "base_link", "base_footprint", (0.0, 0.0, -0.036)
    )
    return Own(robot("vacuum", [body, *wheels, roller, under, cliff, tower, bottom]))


def on_swivels() -> Own:
    """A transporter: driven wheels in the middle, four casters that swivel and trail, a mast."""
    body = link("base_link", box(0.8, 0.5, 0.2), inertial(60.0, 4.0), xyz="0 0 0.2")
    parts = [body, *pair(0.0625, 0.22, 0.0, 0.0625)]
    for k, (x, y) in enumerate(((0.3, 0.2), (0.3, -0.2), (-0.3, 0.2), (-0.3, -0.2))):
        turn = joint(f"swivel_{k}", "base_link", f"fork_{k}", (x, y, 0.1), "0 0 0", "continuous",
                     "0 0 1")  # fmt: skip
        parts += [link(f"fork_{k}"), turn]
        parts.append(wheel(f"support_{k}", (-0.04, 0.0, -0.05), 0.05, f"fork_{k}"))
    parts.append(lidar("front_laser", (0.35, 0.2, 0.12), f"{PI} 0 {PI / 4}", rays=541, far=20.0))
    return Own(robot("transporter", parts))


def with_arm() -> Own:
    """A torso that slides and an arm that turns, on a base with a LiDAR that hangs upside down."""
    body = link("base_link", cylinder(0.27, 0.3), inertial(70.0, 1.2), xyz="0 0 0.2")
    torso = link("torso", box(0.2, 0.2, 0.5), inertial(13.0, 0.3), xyz="0 0 0.25")
    rise = joint("torso_lift_joint", "base_link", "torso", (-0.05, 0, 0.35), "0 0 0", "prismatic",
                 "0 0 1")  # fmt: skip
    arm = link("arm", box(0.3, 0.08, 0.08), inertial(3.0, 0.03), xyz="0.1 0 0")
    turn = joint("shoulder_joint", "torso", "arm", (0.1, 0, 0.45), "0 0 0", "revolute", "0 0 1")
    wheels = pair(0.065, 0.187, 0.0, 0.065)
    laser = lidar("laser_link", (0.235, 0.0, 0.2), f"{PI} 0 0", rays=662, far=25.0,
                  first=-1.91986, last=1.91986)  # fmt: skip
    return Own(robot("with_arm", [body, torso, rise, arm, turn, *wheels, laser]))


def rover() -> Own:
    """Four wheels with inverted axes, base_link above the ground, names behind a slash."""
    body = link("base_link", box(0.5, 0.35, 0.15), inertial(30.0, 1.0), xyz="0 0 0.05")
    parts = [body]
    for end, x in (("front", 0.2), ("rear", -0.2)):
        for side, y in (("left", 0.22), ("right", -0.22)):
            name = f"{end}_{side}"
            parts.append(link(f"{name}_wheel", cylinder(0.1, 0.06), inertial(1.5, 0.01),
                              rpy=f"{PI / 2} 0 0"))  # fmt: skip
            parts.append(joint(f"{name}_wheel_joint", "base_link", f"{name}_wheel", (x, y, 0.03),
                               "0 0 0", "continuous", "0 -1 0"))  # fmt: skip
    parts.append(lidar(xyz=(0.1, 0.0, 0.25), rays=720, far=30.0))
    return Own(robot("rover", parts))


TRAITS |= {
    "LiDAR upside down": hanging,
    "cliff sensors": with_cliff_sensors,
    "two scanners": two_scanners,
    "own base_footprint_joint": own_footprint_joint,
    "planar_move, fixed wheels": planar_move,
    "planar_move, three that turn": lambda: planar_move(True),
    "velocity control, mecanum": mecanum_that_is_moved,
    "footprint that is rounded": many_sided,
    "vacuum cleaner": dropping_wheels,
    "transporter on swivels": on_swivels,
    "torso and arm": with_arm,
    "rover": rover,
}


def car(plugin: str = "", kind: str = "revolute", ends: tuple[str, ...] = ("front",)) -> Own:
    """Wheels that turn on knuckles, and those behind them on a rigid axle."""
    parts = [link("base_link", box(0.6, 0.3, 0.1), inertial(8.0, 0.2), xyz="0 0 0.12")]
    for end, x in (("front", 0.2), ("rear", -0.2)):
        for side, y in (("left", 0.17), ("right", -0.17)):
            name = f"{end}_{side}"
            if end in ends:
                turn = joint(f"{name}_steering", "base_link", f"{name}_knuckle", (x, y, 0.06),
                             "0 0 0", kind, "0 0 1")  # fmt: skip
                parts += [link(f"{name}_knuckle"), turn]
                parts.append(wheel(name, (0.0, 0.0, 0.0), 0.06, f"{name}_knuckle"))
            else:
                parts.append(wheel(name, (x, y, 0.06), 0.06))
    return Own(robot("car", [*parts, plugin, lidar(xyz=(0.1, 0.0, 0.25))]))


def tricycle() -> Own:
    """One steered wheel in front, two behind."""
    fork = joint("fork_joint", "base_link", "fork", (0.2, 0, 0.06), "0 0 0", "revolute", "0 0 1")
    front = [link("fork"), fork, wheel("front", (0.0, 0.0, 0.0), 0.06, "fork")]
    rear = [wheel(s, (-0.2, y, 0.06), 0.06) for s, y in (("left", 0.17), ("right", -0.17))]
    body = link("base_link", box(0.6, 0.3, 0.1), inertial(8.0, 0.2), xyz="0 0 0.12")
    return Own(robot("tricycle", [body, *front, *rear, lidar(xyz=(0.1, 0.0, 0.25))]))
