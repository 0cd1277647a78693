"""ROS 2 and DDS as all processes use them.

What a module imports of its folder stands above it:

    addresses       Addresses of this machine and of others: what a server listens on, what
                    hosts bind to
    rcl_take        Takes serialized messages from rcl itself, which says who sent them; rclpy
                    leaves that out
    rclpy_compat    The private parts of rclpy that we use, all in one place; written for rclpy
                    7.1 (Jazzy)
    rejections      Inputs that the doors of a process reject: counted by kind, reported once
                    per kind and source
    other_ros       Keeps a sourced ROS 2 that this Python cannot use out of our processes
    ros_env         Environment of ROS 2 that every process of a swarm wants; set before rclpy
                    is imported
    sealed          Sealed messages between hosts: written by a holder of the secret, for this
                    run, just now
    secret          The secret that the hosts of a swarm share: made and shown by the world's
                    host
    topic_table     Every topic of a swarm that people look at or record: name, type, quality.
                    Knows no ROS
    beacon_batch    All beacons that the robots of one host receive at a tick, as one message:
                    each beacon once
    tick_action     Action servers that never block: a goal is handed on and its result sent at
                    the end
    simulation      Where messages of simulation_interfaces 1.x and 2.x differ
    dds_profile     DDS profiles of a swarm on several hosts: one address to bind to, peers by
                    unicast only
    cdr_layout      Where the numbers of a CDR message are that begins with a stamp and some
                    strings
    participants    DDS participants over which a process spreads the topics of a large swarm
    ros_poll        Topics that are polled instead of called back: the cheap way to receive
                    messages every tick
    beacon_kernels  Numba kernel of the radio's door: which beacons say what no robot can mean
    cdr             CDR bytes of the messages sent every tick: odometry, scan, command
    radio_door      The door of the radio: bytes of `beacon` and `neighbors`, checked before a
                    kernel reads them
    ros_io          Every ROS message that is not sent each tick, to and from our records; and
                    the QoS profiles

May import of swarm_common: `robots`, `files`, `model`, `process`.
"""
