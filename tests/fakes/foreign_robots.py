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


MECANUM = """controller_manager:
  ros__parameters:
    update_rate: 50
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    base: {type: mecanum_drive_controller/MecanumDriveController}
base:
  ros__parameters:
    front_left_wheel_command_joint_name: front_left_wheel_joint
    front_right_wheel_command_joint_name: front_right_wheel_joint
    rear_left_wheel_command_joint_name: rear_left_wheel_joint
    rear_right_wheel_command_joint_name: rear_right_wheel_joint
    kinematics: {wheels_radius: 0.05, sum_of_robot_center_projection_on_X_Y_axis: 0.32}
"""
DIFFERENTIAL = """/**:
  controller_manager:
    ros__parameters:
      base:
        type: diff_drive_controller/DiffDriveController
  base:
    ros__parameters:
      left_wheel_names: ["$(var prefix)left_wheel_joint"]
      right_wheel_names: ["$(var prefix)right_wheel_joint"]
      wheel_separation: 0.3
      wheel_radius: 0.05
      linear.x.has_velocity_limits: true
      linear.x.max_velocity: 0.6
      linear.x.max_acceleration: 1.1
      angular:
        z: {max_velocity: 1.7, max_acceleration: 2.2}
"""


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


SDF = """<?xml version="1.0"?>
<sdf version="1.8"><model name="tb">
  <link name="base_footprint"/>
  <link name="base_link"><pose>0 0 0.01 0 0 0</pose>
    <inertial><pose>-0.064 0 0.048 0 0 0</pose><mass>1.3729</mass><inertia><ixx>0.0087</ixx>
      <iyy>0.0086</iyy><izz>0.0146</izz></inertia></inertial>
    <collision name="body"><pose>-0.064 0 0.047 0 0 0</pose>
      <geometry><box><size>0.266 0.266 0.094</size></box></geometry></collision></link>
  <link name="base_scan"><pose>-0.064 0 0.121 0 0 0</pose>
    <inertial><mass>0.1</mass></inertial>
    <collision name="scan"><geometry><cylinder><radius>0.05</radius><length>0.03</length></cylinder>
      </geometry></collision>
    <sensor name="lidar" type="gpu_lidar"><pose>0 0 0.02 0 0 0</pose><update_rate>5</update_rate>
      <gz_frame_id>base_scan</gz_frame_id><lidar><scan><horizontal><samples>360</samples>
      <min_angle>0</min_angle><max_angle>6.28</max_angle></horizontal></scan>
      <range><min>0.12</min><max>3.5</max></range></lidar></sensor></link>
  <link name="left_wheel"><pose>0 0.144 0.033 -1.5708 0 0</pose>
    <inertial><mass>0.1</mass><inertia><ixx>1.8e-4</ixx><iyy>1.8e-4</iyy><izz>3.2e-4</izz></inertia>
    </inertial><collision name="tyre"><geometry><cylinder><radius>0.033</radius>
      <length>0.018</length></cylinder></geometry><surface/></collision></link>
  <link name="right_wheel"><pose relative_to="left_wheel">0 0 -0.288 0 0 0</pose>
    <inertial><mass>0.1</mass><inertia><ixx>1.8e-4</ixx><iyy>1.8e-4</iyy><izz>3.2e-4</izz></inertia>
    </inertial><collision name="tyre"><geometry><cylinder><radius>0.033</radius>
      <length>0.018</length></cylinder></geometry></collision></link>
  <link name="caster"><pose>-0.177 0 0.005 0 0 0</pose>
    <inertial><mass>0.005</mass><inertia><ixx>1e-6</ixx><iyy>1e-6</iyy><izz>1e-6</izz></inertia>
    </inertial><collision name="ball"><geometry><sphere><radius>0.005</radius></sphere></geometry>
    </collision></link>
  <joint name="base_joint" type="fixed"><parent>base_footprint</parent><child>base_link</child>
  </joint>
  <joint name="left_joint" type="revolute"><parent>base_link</parent><child>left_wheel</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis></joint>
  <joint name="right_joint" type="revolute"><parent>base_link</parent><child>right_wheel</child>
    <axis><xyz expressed_in="__model__">0 1 0</xyz></axis></joint>
  <joint name="caster_joint" type="ball"><parent>base_link</parent><child>caster</child></joint>
  <joint name="scan_joint" type="fixed"><parent>base_link</parent><child>base_scan</child></joint>
  <plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
    <left_joint>left_joint</left_joint><right_joint>right_joint</right_joint>
    <wheel_separation>0.288</wheel_separation><wheel_radius>0.033</wheel_radius>
    <max_linear_velocity>0.26</max_linear_velocity><max_angular_velocity>1.8</max_angular_velocity>
    <max_linear_acceleration>1</max_linear_acceleration>
    <max_angular_acceleration>3.2</max_angular_acceleration><topic>cmd_vel</topic></plugin>
</model></sdf>
"""
CONFIG = """<?xml version="1.0"?><model><name>tb</name>
<sdf version="1.4">old.sdf</sdf><sdf version="1.8">model.sdf</sdf></model>
"""


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
