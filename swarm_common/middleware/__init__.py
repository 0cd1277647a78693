"""ROS 2 and DDS as all processes use them.

What a module imports of its folder stands above it:

    addresses       Addresses of this machine and of others
    rcl_take        Receives serialized messages from rcl itself, which says who sent them
    rclpy_compat    The private parts of rclpy that we use, all in one place
    graph_watch     Says whether the ROS graph has changed
    rejections      Inputs that the doors of a process reject
    other_ros       Keeps a sourced ROS 2 that this Python cannot use out of our processes
    ros_env         Environment of ROS 2 that every process of a swarm wants
    sealed          Sealed messages between hosts, by a holder of the secret
    secret          The secret that the hosts of a swarm share
    topic_table     Every topic of a swarm that people look at or record
    beacon_batch    All beacons for the robots of one host at a tick, as one message
    tick_action     Action servers that never block
    dds_profile     DDS profiles of a swarm on several hosts: peers by unicast only
    central_io      Reports and orders of a centre, to and from ROS messages
    courier_io      Reports of ticks to a courier, and their releases
    directed_io     Directed zones of a robot, to and from a ROS message
    cdr_layout      Positions of the numbers in a CDR message
    participants    DDS participants over which a process spreads the topics of a large swarm
    ros_poll        Topics that are polled instead of called back, every tick
    beacon_kernels  Numba kernel of the radio's door: which beacons say what no robot can mean
    cdr             CDR bytes of the messages sent every tick: odometry, scan, command
    radio_check      The door of the radio: bytes of beacons, checked before a kernel reads them
    ros_io          ROS messages that are not sent each tick, to and from our records

May import of swarm_common: `robots`, `files`, `model`, `process`.
"""
