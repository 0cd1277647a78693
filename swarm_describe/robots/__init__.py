"""Robot models: from a description or robot.yaml to a RobotSpec.

What a module imports of its folder stands above it:

    drive_tags    Statements of a plugin or a controller on a robot's drive
    gazebo_tags   Drive and LiDAR in the `<gazebo>` elements of a URDF
    urdf_tree     A URDF text as a checked XML tree: one root, no loops, every number finite
    grammar       The elements and attributes of URDF and SDF: read, of no concern, or unknown
    spec          Content of `robot.yaml`; a `RobotSpec` from values by name, each checked
    controllers   Limits of a robot's drive in the parameter files of ros2_control
    description   Reading of a robot's description (URDF)
    sdf_robot     A robot described in SDF: its links and joints as a URDF tree
    tyres         Contact of a wheel with the ground: the radius of its tyre, and its place
    drive_train   Joints that drive a robot, and properties that follow from its wheels
    lidar_choice  Choice of the LiDAR among a description's sensors, and how it is mounted
    source        Source of a robot: our folder, or the user's files
    derived       Facts in a robot's description, as far as it has them
    loading       Robot models, from `robot.yaml` and the description
    fleet         Fleets of several robot models (`--fleet`): the model and limits of each robot

May import of swarm_describe: `worlds`, `files`; and swarm_common.
"""
