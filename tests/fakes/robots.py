"""Robot packages in the form that real ones have, written for a test."""

from pathlib import Path

PACKAGE = """<?xml version="1.0"?>
<package format="3"><name>{name}</name><version>0.0.1</version>
  <description>For a test</description><maintainer email="a@example.com">a</maintainer>
  <license>Apache-2.0</license></package>
"""

LIMITS = "max_vel_x: 0.5\nmax_vel_theta: 1.5\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"

# A plain URDF: base_link as its root, a caster that swivels, missing inertials, names behind a
# placeholder, a mesh as its body, Gazebo Classic's plugins.
URDF = """<?xml version="1.0"?>
<robot name="acme">
  <link name="${namespace}base_link">
    <inertial><origin xyz="0.02 0 0"/><mass value="4.0"/>
      <inertia ixx="0.03" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.06"/></inertial>
    <collision><origin xyz="0 0 0.02"/>
      <geometry><mesh filename="package://acme_description/meshes/body.stl"
                      scale="0.001 0.001 0.001"/></geometry></collision>
  </link>
  <link name="${namespace}left_wheel">
    <inertial><mass value="0.2"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="1e-4"/></inertial>
    <collision><origin rpy="1.5707963 0 0"/>
      <geometry><cylinder radius="0.05" length="0.02"/></geometry></collision>
  </link>
  <link name="${namespace}right_wheel">
    <collision><origin rpy="1.5707963 0 0"/>
      <geometry><cylinder radius="0.05" length="0.02"/></geometry></collision>
  </link>
  <link name="${namespace}caster"/>
  <link name="${namespace}caster_wheel">
    <collision><origin rpy="1.5707963 0 0"/>
      <geometry><cylinder radius="0.03" length="0.01"/></geometry></collision>
  </link>
  <link name="${namespace}lidar_link"/>
  <joint name="left_wheel_joint" type="continuous">
    <parent link="${namespace}base_link"/><child link="${namespace}left_wheel"/>
    <origin xyz="0.05 0.15 -0.02"/><axis xyz="0 1 0"/></joint>
  <joint name="right_wheel_joint" type="continuous">
    <parent link="${namespace}base_link"/><child link="${namespace}right_wheel"/>
    <origin xyz="0.05 -0.15 -0.02"/><axis xyz="0 1 0"/></joint>
  <joint name="swivel_joint" type="continuous">
    <parent link="${namespace}base_link"/><child link="${namespace}caster"/>
    <origin xyz="-0.15 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="caster_wheel_joint" type="continuous">
    <parent link="${namespace}caster"/><child link="${namespace}caster_wheel"/>
    <origin xyz="0 0 -0.04"/><axis xyz="0 1 0"/></joint>
  <joint name="lidar_joint" type="fixed">
    <parent link="${namespace}base_link"/><child link="${namespace}lidar_link"/>
    <origin xyz="0.1 0 0.12" rpy="0 0 1.5707963"/></joint>
  <gazebo>
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so">
      <ros><namespace>/${namespace}</namespace></ros>
      <left_joint>left_wheel_joint</left_joint><right_joint>right_wheel_joint</right_joint>
      <wheel_separation>0.3</wheel_separation><wheel_diameter>0.1</wheel_diameter>
      <max_wheel_acceleration>1.5</max_wheel_acceleration>
    </plugin>
  </gazebo>
  <gazebo reference="${namespace}lidar_link">
    <material>Gazebo/Black</material>
    <sensor name="lidar" type="ray">
      <update_rate>10</update_rate>
      <ray><scan><horizontal><samples>181</samples><min_angle>-1.5707963</min_angle>
        <max_angle>1.5707963</max_angle></horizontal></scan>
        <range><min>0.1</min><max>8.0</max></range>
        <noise><type>gaussian</type><stddev>0.02</stddev></noise></ray>
      <plugin name="scan" filename="libgazebo_ros_ray_sensor.so"/>
    </sensor>
  </gazebo>
</robot>
"""

XACRO = """<?xml version="1.0"?>
<robot name="acme_big" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="namespace" default=""/>
  <xacro:arg name="big" default="false"/>
  <xacro:property name="ns" value="$(arg namespace)"/>
  <xacro:include filename="$(find acme_parts)/urdf/wheel.xacro"/>
  <link name="${ns}base_footprint"/>
  <link name="${ns}base_link">
    <collision><geometry><box size="${0.6 if '$(arg big)' == 'true' else 0.4} 0.2 0.1"/>
    </geometry></collision>
  </link>
  <joint name="base_joint" type="fixed">
    <parent link="${ns}base_footprint"/><child link="${ns}base_link"/><origin xyz="0 0 0.1"/>
  </joint>
  <xacro:acme_wheel name="front_left" x="0.1" y="0.15"/>
  <xacro:acme_wheel name="front_right" x="0.1" y="-0.15"/>
  <xacro:acme_wheel name="rear_left" x="-0.1" y="0.15"/>
  <xacro:acme_wheel name="rear_right" x="-0.1" y="-0.15"/>
  <link name="laser"/>
  <joint name="laser_joint" type="fixed">
    <parent link="base_link"/><child link="laser"/><origin xyz="0.1 0 0.1"/></joint>
</robot>
"""

WHEEL = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="sizes.xacro"/>
  <xacro:macro name="acme_wheel" params="name x y">
    <link name="${name}_wheel">
      <inertial><mass value="0.5"/>
        <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
      <collision><geometry>
        <mesh filename="package://acme_parts/meshes/wheel.obj"/></geometry></collision>
    </link>
    <joint name="${name}_wheel_joint" type="continuous">
      <parent link="base_link"/><child link="${name}_wheel"/>
      <origin xyz="${x} ${y} ${radius - 0.1}"/><axis xyz="0 -1 0"/></joint>
  </xacro:macro>
</robot>
"""

SIZES = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="radius" value="0.06"/>
</robot>
"""


def write_packages(workspace: Path) -> tuple[Path, Path]:
    """Write a workspace with two packages; return the paths of a URDF and of a xacro."""
    import trimesh

    own, parts = workspace / "acme" / "acme_description", workspace / "vendor" / "acme_parts"
    for folder, name in ((own, "acme_description"), (parts, "acme_parts")):
        for child in ("urdf", "meshes"):
            (folder / child).mkdir(parents=True)
        (folder / "package.xml").write_text(PACKAGE.format(name=name), encoding="utf-8")
    trimesh.creation.box((400.0, 200.0, 60.0)).export(own / "meshes" / "body.stl")
    wheel = trimesh.creation.cylinder(radius=0.06, height=0.04, sections=24)
    wheel.apply_transform(trimesh.transformations.rotation_matrix(1.5707963, (1.0, 0.0, 0.0)))
    wheel.export(parts / "meshes" / "wheel.obj")
    (parts / "urdf" / "wheel.xacro").write_text(WHEEL, encoding="utf-8")
    (parts / "urdf" / "sizes.xacro").write_text(SIZES, encoding="utf-8")
    urdf, xacro = own / "urdf" / "acme.urdf", own / "urdf" / "acme_big.urdf.xacro"
    urdf.write_text(URDF, encoding="utf-8")
    xacro.write_text(XACRO, encoding="utf-8")
    return urdf, xacro
