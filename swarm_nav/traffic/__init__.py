"""Rules between robots: reservation of space, right of way, stations, narrow regions.

What a module imports of its folder stands above it:

    gate_kernels      Bare numba kernels of entry control
    narrows_kernels   Bare numba kernels of single-lane passages
    parting_kernels   Bare numba kernel: which part of a held tube a radius that has grown takes
                      from others
    patience_kernels  Bare numba kernel of the radio's round trip
    patience          One scale for all times of the liveness layer: how slow the radio is, as
                      measured
    situation         What all parts of one navigator share: the robot's state at the present
                      tick
    caution           Caution around people: who stands may be walked up to, who drives may be
                      walked into
    crowd             How other robots enter the search lattice: as costs to go around, or as
                      walls for a refuge
    gate              Entry control: how many robots may be in a narrow region that has stations
                      (perimeter control)
    narrows           Single-lane passages: which direction goes first through a door that two
                      robots cannot pass in
    senses            What the robot sees and hears of the world, and whether enough of it comes
                      to drive on
    claim             The robot's claim to space: extends, guards and gives up the held tube,
                      tick by tick
    holding           Stations: leases in the order of request, and the holding pattern until it
                      is one's turn
    right_of_way      Liveness layer: who has right of way, who makes way, who steps back
    departure         Leaving a narrow region with stations after the last goal there, when
                      others wait to get in

May import of swarm_nav: `localisation`, `control`, `perception`, `planning`, `core`; and
swarm_common.
"""
