"""A package in the form that real ones have: a Gazebo world, models with configs, and meshes."""

from pathlib import Path

import shapely
import trimesh

CONFIG = """<?xml version="1.0"?>
<model><name>{name}</name><version>1.0</version>
<sdf version="1.4">model-1_4.sdf</sdf><sdf version="1.6">model.sdf</sdf>
<description>for tests</description></model>
"""
TABLE = """<?xml version="1.0"?>
<sdf version="1.6"><model name="table"><static>true</static>
  <link name="top">
    <pose>0 0 0.75 0 0 0</pose>
    <collision name="c"><geometry><box><size>1.5 0.8 0.04</size></box></geometry></collision>
    <visual name="v"><geometry><box><size>1.5 0.8 0.04</size></box></geometry>
      <material><script><uri>file://media/materials/scripts/gazebo.material</uri>
      <name>Gazebo/Wood</name></script></material></visual>
  </link>
  <link name="leg">
    <pose relative_to="top">0.6 0.3 -0.38 0 0 0</pose>
    <collision name="c"><geometry><cylinder><radius>0.02</radius><length>0.72</length></cylinder>
    </geometry></collision>
  </link>
  <plugin name="p" filename="libtable.so"/>
</model></sdf>
"""
BARRIER = """<?xml version="1.0"?>
<sdf version="1.6"><model name="barrier"><static>1</static>
  <link name="link">
    <inertial><mass>500</mass></inertial>
    <collision name="c"><geometry><mesh><uri>model://barrier/meshes/barrier.dae</uri>
      <scale>0.5 1 1</scale></mesh></geometry></collision>
    <visual name="v"><geometry><mesh><uri>model://barrier/meshes/barrier.dae</uri></mesh>
      </geometry></visual>
    <sensor name="s" type="contact"/>
  </link></model></sdf>
"""
BAY = """<?xml version="1.0"?>
<sdf version="1.7"><model name="bay">
  <static>true</static>
  <frame name="entry" attached_to="__model__"><pose>2 0 0 0 0 0</pose></frame>
  <include><uri>model://table</uri><name>left</name><pose relative_to="entry">0 1 0 0 0 0</pose>
  </include>
  <include><uri>model://table</uri><name>right</name>
    <pose relative_to="left">0 -2 0 0 0 0</pose></include>
  <link name="curb"><pose>0 0 0.1 0 0 0</pose>
    <collision name="c"><geometry><mesh><uri>meshes/curb.stl</uri></mesh></geometry></collision>
  </link>
</model></sdf>
"""
WORLD = """<?xml version="1.0" ?>
<sdf version="1.6">
  <world name="default">
    <include><uri>model://sun</uri></include>
    <include><uri>model://ground_plane</uri></include>
    <physics type="ode"><max_step_size>0.001</max_step_size></physics>
    <scene><ambient>0.4 0.4 0.4 1</ambient></scene>
    <light name="lamp" type="point"><pose>0 0 5 0 0 0</pose></light>
    <plugin name="state" filename="libgazebo_ros_state.so"/>
    <include><uri>model://bay</uri><pose>10 0 0 0 0 1.5707963267948966</pose></include>
    <include><uri>model://barrier</uri><name>barrier_0</name><pose>5 5 0 0 0 0</pose></include>
    <model name="crate">
      <pose>1 1 0.25 0 0 0</pose>
      <link name="link">
        <inertial><mass>4</mass></inertial>
        <collision name="c"><geometry><box><size>0.5 0.5 0.5</size></box></geometry>
          <surface><friction><ode><mu>0.4</mu><mu2>0.4</mu2></ode></friction></surface></collision>
        <visual name="v"><geometry><box><size>0.5 0.5 0.5</size></box></geometry>
          <material><ambient>0.8 0.2 0.1 1</ambient></material></visual>
      </link>
    </model>
    <actor name="clerk">
      <skin><filename>walk.dae</filename></skin>
      <script><loop>true</loop><trajectory id="0" type="walking">
        <waypoint><time>0</time><pose>-2 0 0 0 0 0</pose></waypoint>
        <waypoint><time>4</time><pose>-2 4 0 0 0 1.57</pose></waypoint>
        <waypoint><time>5</time><pose>-2 4 0 0 0 -1.57</pose></waypoint>
        <waypoint><time>9</time><pose>-2 0 0 0 0 -1.57</pose></waypoint>
      </trajectory></script>
    </actor>
    <actor name="truck">
      <link name="body"><collision name="c"><geometry><box><size>2 1 1.8</size></box></geometry>
      </collision></link>
      <script><trajectory id="0" type="drive">
        <waypoint><time>0</time><pose>-8 -4 0 0 0 0</pose></waypoint>
        <waypoint><time>8</time><pose>0 -4 0 0 0 0</pose></waypoint>
      </trajectory></script>
    </actor>
    <gui fullscreen="0"><camera name="user_camera"/></gui>
    <state world_name="default">
      <sim_time>12 0</sim_time>
      <model name="barrier_0"><pose>5 -5 0 0 -0 0.5</pose><scale>1 1 1</scale>
        <link name="link"><pose>5 -5 0 0 -0 0.5</pose><velocity>0 0 0 0 -0 0</velocity></link>
      </model>
      <model name="crate"><pose>3 1 0.25 0 -0 0</pose>
        <link name="link"><pose>3 1 0.25 0 -0 0</pose></link></model>
      <light name="lamp"><pose>0 0 5 0 -0 0</pose></light>
    </state>
  </world>
</sdf>
"""


def write_package(folder: Path) -> Path:
    """Write the package; return its world file."""
    models, worlds = folder / "office" / "models", folder / "office" / "worlds"
    for name, text in (("table", TABLE), ("barrier", BARRIER), ("bay", BAY)):
        (models / name / "meshes").mkdir(parents=True)
        (models / name / "model.config").write_text(CONFIG.format(name=name))
        (models / name / "model.sdf").write_text(text)
        (models / name / "model-1_4.sdf").write_text("<sdf version='1.4'><broken/></sdf>")
    profile = shapely.Polygon(
        [(-0.4, 0), (0.4, 0), (0.1, 0.5), (0.1, 1.1), (-0.1, 1.1), (-0.1, 0.5)]
    )
    barrier = trimesh.creation.extrude_polygon(profile, 4.0)
    barrier.apply_transform([[1, 0, 0, 0], [0, 0, 1, -2], [0, 1, 0, 0], [0, 0, 0, 1]])
    barrier.export(models / "barrier" / "meshes" / "barrier.dae")
    corner = shapely.Polygon([(0, 0), (2, 0), (2, 0.2), (0.2, 0.2), (0.2, 2), (0, 2)])
    curb = trimesh.creation.extrude_polygon(corner, 0.2)
    curb.export(models / "bay" / "meshes" / "curb.stl")
    worlds.mkdir()
    (worlds / "office.world").write_text(WORLD)
    return worlds / "office.world"
