"""Missions without ROS, for commander, bench and Python alike.

What a module imports of its folder stands above it:

    exchange    Goals of robots that change places or roam: drawn for the whole swarm from one seed
    way_table   Lengths and directions of the shortest ways to goals
    wait_graph  Which robot waits for which, and circles of waiting that last
    leg         One part of a mission's route, and the goals that it means for a robot
    energy      Whether batteries can be enough for a mission: what is certain before a run
    itinerary   One robot's way through its stops: what to send next
    mission     Missions as written in `params/missions/*.yaml`
    routes      Where missions lead each robot of a swarm

May import swarm_common only.
"""
