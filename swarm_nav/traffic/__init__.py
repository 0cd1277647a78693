"""Rules between robots: reservation of space, right of way, stations, narrow regions.

What a module imports of its folder stands above it:

    single_lane_kernels  Bare numba kernels of single-lane passages
    gate_kernels         Bare numba kernels of the floor that robots queue for
    patience             One scale for all times of liveness: the measured slowness of the radio
    robot_view           That state as rules see it: to be read only
    robot_state          State at the present tick, which all parts of one navigator share
    command              The way that a centre gives a robot
    stop_filter          The last thing before a command leaves, whoever made it
    speed_limits         Limits of speed zones and of the topic `speed_limit`: the lowest counts
    speed_near_people    A person may walk into a driving robot, but not into a standing one
    traffic_costs        Costs of other robots on the search lattice, or walls in their places
    gate                 Admission control of a narrow region with stations (perimeter control)
    single_lanes         Direction that goes first through a door too narrow for two robots
    lane_group           Connected single lanes, and how many robots may have goals there at a time
    conditions           Under which conditions every robot reaches every goal, before a run
    senses               Scans and beacons received, and whether they suffice to drive on
    arbiter              The only writer of path and held space; what rules propose
    held_space_rules     Rules that give up held space
    zone                 The floor that a robot at a station needs, for how many, in which order
    lease                Leases of stations, in the order of request
    holding              Waiting place of a robot until it is its turn at a station
    right_of_way         Liveness layer: which robot has right of way, makes way, or steps back
    departure            Leaving the place of the last goal when others want to go there

May import of swarm_nav: `localisation`, `control`, `reservation`, `perception`, `planning`,
`core`; and swarm_common.
"""
