"""Rules between robots: reservation of space, right of way, stations, narrow regions.

What a module imports of its folder stands above it:

    conditions_kernels   Bare numba kernels of the conditions of a run: the blind ends of lanes
    gate_kernels         Bare numba kernels of entry control
    single_lane_kernels  Bare numba kernels of single-lane passages
    overlap_kernels      Bare numba kernel: which part of a held tube a radius that has grown takes
                         from others
    patience_kernels     Bare numba kernel of the radio's round trip
    patience             One scale for all times of the liveness layer: the measured slowness of the
                         radio
    situation            What all parts of one navigator share: the robot's state at the present
                         tick
    speed_near_people    Speed near people: a person may walk into a driving robot, but not into a
                         standing one
    traffic_costs        How other robots enter the search lattice: as costs to go around, or as
                         walls for a refuge
    gate                 Admission control: limits the robots in a narrow region with stations
                         (perimeter control)
    single_lanes         Single-lane passages: which direction goes first through a door too narrow
                         for two robots
    conditions           Under which conditions every robot reaches every goal, checked against a
                         map before a run
    senses               What the robot sees and hears of the world, and whether enough of it comes
                         to drive on
    reservation          The robot's claim to space: extends, guards and gives up the held tube,
                         tick by tick
    holding              Stations: leases in the order of request, and the holding pattern until it
                         is one's turn
    right_of_way         Liveness layer: which robot has right of way, makes way, or steps back
    departure            Leaving a narrow region with stations after the last goal there, when
                         others wait to get in

May import of swarm_nav: `localisation`, `control`, `perception`, `planning`, `core`; and
swarm_common.
"""
