"""Starting navigators: one warm parent that forks a process per robot.

What a module imports of its folder stands above it:

    shared_precomputation  What all robots would work out of the map and its stations, worked
                           out once before the fork
    navigator_process      What runs in a navigator process: one navigator, or a pack of them
    warm_up                Compile, or load from numba's disk cache, every kernel before robots
                           are forked
    process_groups         Which robots share a navigator process, and to which participants it
                           announces itself
    fork_server            Forks, watches and ends the navigators' processes
    fork_server_main       The fork server: `python -m swarm_nav.launch.fork_server_main
                           CONFIG.json [--event-fd N] [--control-fd M]`

May import of swarm_nav: `ros`, `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
