"""Robot models: from a description or robot.yaml to a RobotSpec.

What a module imports of its folder stands above it:

    gazebo_tags   What the `<gazebo>` elements of a URDF say about drive and LiDAR, of Classic
                  and of Sim
    packages      ROS packages on disk: where `package://` URIs and `$(find package)` lead
    params        A robot model as the ROS parameters `robot.*` of its navigator, and back
    sensors_io    Reading of a robot's sensor errors: the section `sensors:` of robot.yaml,
                  checked
    urdf_tree     A URDF text as a checked XML tree: one root, no loops, every number finite
    description   Reading of a robot's description (URDF): links, joints, collision shapes,
                  masses
    xacro_compat  The private parts of xacro that we use, all in one place; written for xacro
                  2.1
    xacro_io      Expansion of xacro files, with errors that name file and line
    drive_train   Which joints drive a robot, and what follows from where its wheels are
    lidar_choice  Which of a description's ray sensors is the LiDAR, and how it is mounted
    source        Where a robot comes from: a folder of `robots/`, or the user's URDF, xacro or
                  `robot.yaml`
    derived       What a robot's description says about it: drive, footprint, LiDAR, and limits
                  where it can
    spec          A `RobotSpec` from values by name, each checked: those of `robot.yaml` and
                  those derived
    loading       Robot models: what world and navigator must agree on, from `robot.yaml` and
                  the description
    fleet         Fleets of several robot models (`--fleet`): the model and limits of each robot

May import of swarm_common: `files`, `model`, `process`.
"""
