"""Vocabulary shared by the world, the robots and the operator; may be imported by every package.

Lower folders never import higher ones; the lowest stands first:

    model       Values that all parties speak of
    process     What processes ask of the kernel and of each other
    files       Files that are read and written: maps, sites, caches, the data that ships with the
                project
    robots      Robot models: from a description or robot.yaml to a RobotSpec
    middleware  ROS 2 and DDS as all processes use them
"""
