"""The navigator on the ROS graph: messages in, one call of the brain per tick, messages out.

What a module imports of its folder stands above it:

    answer_barrier  Withholds the answer to a tick, so that missions are repeatable
    inputs          Collects what belongs to one control tick
    nav2            Nav2's actions, services and topics, as clients of Nav2 know them
    settings        A navigator's parameter file: what is fixed, and the brain's parameters
    status          The state of a robot for its operator, as bytes
    answer          The answer to a tick on the node: beacon and command, sent at once or withheld
    centre_link     Reports to a centre, and its orders
    courier_link    Reports of ticks to a courier, and which ticks it has released
    bare_node       The bare ROS node of a navigator, and its clock
    params          The ROS parameters of a navigator, some of which can be set while it runs
    node            Topics in, one call of the brain per tick, topics out
    loop            The loop of a navigator process: waits for ticks, does the rest in between
    types           Loading of the C side of all message types before the navigators are forked

May import of swarm_nav: `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
