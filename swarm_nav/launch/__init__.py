"""Starting navigators: one warm parent that forks a process per robot.

What a module imports of its folder stands above it:

    shared_precomputation  Results from the map that all robots share, computed once
    navigator_process      Work of a navigator process: one navigator, or a pack of them
    warm_up                Compile or load every kernel before robots are forked
    process_groups         Packs of robots that share a navigator process
    fork_server            Forks, watches and ends the navigators' processes
    fork_server_main       The process of the fork server

May import of swarm_nav: `ros`, `behaviour`, `traffic`, `localisation`, `control`, `perception`,
`planning`, `core`; and swarm_common.
"""
