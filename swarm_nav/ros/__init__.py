"""The navigator on the ROS graph: messages in, one call of the brain per tick, messages out.

What a module imports of its folder stands above it:

    clock               Simulated time of a navigator's node, from the ticks that it sees anyway
    demand              Servers and topics that exist only once somebody looks for them, or that
                        come after the start
    inputs              Collects what belongs to one control tick: odometry, neighbours, and the
                        scan when it is due
    reach               How far away anything can be that means something on the map at hand
    settings            A navigator's parameter file: what is fixed at the start, and the brain's
                        parameters
    status              The state of a robot for its operator, as bytes: a Python message takes
                        longer than a tick
    costmaps            A costmap on Nav2's topics: whole and in parts, as occupancy and with its
                        raw costs
    views               What a navigator shows to viewers, sent only while they subscribe
    answer_barrier      When a navigator withholds the answer to a tick, so that a mission's outcome
                        is repeatable
    answer              The answer to a tick on the node: beacon and command, sent at once or
                        withheld
    bare_node           The bare ROS node of a navigator
    goals               Nav2's action goals, feedback and results, to and from the brain's
    params              The ROS parameters of a navigator: the brain's can be set while it runs, the
                        others not
    lifecycle_services  Nav2's nodes as the graph shows them: names with lifecycle services, in one
                        process and state
    services            Nav2's services on the node: lifecycle, costmaps, map
    plans               Nav2's planning actions on the node: a leg at a time, so that no plan keeps
                        a tick waiting
    poses               Poses that arrive with a frame, in map
    tasks               Nav2's navigation actions and goal_pose on the node: requests in, feedback
                        and results out
    node                One robot's navigator on the ROS graph: topics in, one call of the brain per
                        tick, topics out
    loop                The loop of a navigator process: it waits for ticks, and does everything
                        else in between
    types               Loading of the C side of all message types before the navigators are forked

May import of swarm_nav: `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
