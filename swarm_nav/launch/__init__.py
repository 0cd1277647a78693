"""Starting navigators: one warm parent that forks a process per robot.

What a module imports of its folder stands above it:

    common_ground  What all robots would work out of the map and its stations, worked out once
                   before the fork
    pack           What runs in a navigator process: one navigator, or a pack of them
    warm_up        Compile, or load from numba's disk cache, every kernel before robots are
                   forked
    group          Which robots share a navigator process, and whom that process announces
                   itself to
    nursery        Forks, watches and ends the navigators' processes
    host           The nursery: `python -m swarm_nav.launch.host CONFIG.json [--event-fd N]
                   [--control-fd M]`

May import of swarm_nav: `ros`, `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
