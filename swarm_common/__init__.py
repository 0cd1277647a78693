"""Vocabulary shared by the world, the robots and the operator; may be imported by every package.

Lower folders never import higher ones; the lowest stands first:

    model       Values that all parties speak of
    process     What processes ask of the kernel and of each other
    files       Files that are read and written: maps, sites, caches, the data that ships with the
                project
    robots      Robot models: from a description or robot.yaml to a RobotSpec
    middleware  ROS 2 and DDS as all processes use them

What holds for every function here and in `swarm_sim`, unless its docstring says otherwise:

    units   Metres, radians, seconds and kilograms.
    frames  Places and poses (x, y, yaw) are in the map frame.
    time    `now` is wall time; `tick` is the current control tick.
    places  `where` and `what` name the file and key, or the element, that a message is about.
    errors  What cannot be used raises the `SwarmError` of its kind (`model/errors.py`). The message
            says what was found, where, and what to do. A client's request raises RefusedError, a
            message from the network RejectedError.
"""
