"""The world on the ROS graph, and its process.

What a module imports of its folder stands above it:

    pacing      Throttle to a multiple of real time, and rates that are limited on the wall clock
    services    The services `/sim/...`: who and what is there, whether time goes on, and questions
    settings    Configuration of the world process: a JSON file that swarm-up writes
    viewing     The world as viewers see it
    build       Construction of a world from the settings, which are checked here
    robots      The robots' topics on the side of the world, and the lockstep with their navigators
    trace       Light time series of the truth for the report: where everybody was, once a second
    report      Reports on a run: twice a second while it goes on, and at its end
    world_node  The world as a node: what happens between two ticks, and in one
    node        The world's process

May import of swarm_sim: `world`, `sensing`, `maps`, `physics`, `scene`; and lower packages.
"""
