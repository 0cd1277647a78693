"""The navigator on the ROS graph: messages in, one call of the brain per tick, messages out.

What a module imports of its folder stands above it:

    answer_barrier  When a navigator withholds the answer to a tick, so that a mission's outcome is
                    repeatable
    clock           Simulated time of a navigator's node, from the ticks that it sees anyway
    inputs          Collects what belongs to one control tick: odometry, neighbours, and the scan
                    when it is due
    nav2            Nav2's actions, services and topics, as clients of Nav2 know them
    settings        A navigator's parameter file: what is fixed at the start, and the brain's
                    parameters
    status          The state of a robot for its operator, as bytes: a Python message takes longer
                    than a tick
    answer          The answer to a tick on the node: beacon and command, sent at once or withheld
    bare_node       The bare ROS node of a navigator
    params          The ROS parameters of a navigator: the brain's can be set while it runs, the
                    others not
    node            One robot's navigator on the ROS graph: topics in, one call of the brain per
                    tick, topics out
    loop            The loop of a navigator process: it waits for ticks, and does everything else in
                    between
    types           Loading of the C side of all message types before the navigators are forked

May import of swarm_nav: `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
