"""Descriptions of robots and worlds by others, as a `RobotSpec` and a `Scene`.

Lower folders never import higher ones; the lowest stands first:

    files   Files of descriptions: where they are, XML, xacro, meshes
    worlds  Worlds of Gazebo, and what is in a world after reading
    robots  Robot models: from a description or robot.yaml to a RobotSpec

May import swarm_common only.
"""
