"""A run is a value: what describes it, what checks and loads it, and what reaches it over ROS.

What a module imports of its folder stands above it:

    command_line      A command as a process: what it needs before its imports, and how it ends
    record            What is known of a run that is over: report.json, the bench's line
    robots            Robots of a running swarm over ROS: found, watched, driven
    domain            One swarm per ROS domain, since two would have the same names; its owner takes
                      requests
    listing           What `swarm-up --list` shows: worlds, missions, robots and fleets
    host_options      Options of a run on several hosts, checked once
    loop              The loop of a run in one process: all robots sense, decide, act
    fleet_link        How the robots reach a fleet control of another maker
    packing           Number of navigators that share a process
    spec              The one description of a run: `RunSpec`
    params            Parameter files: defaults, the robot's data, the user's overrides for
                      navigators and world
    lanes             Whether preferred lanes were learned for the world and mission of a run
    plan              Everything that is checked and loaded before a run starts a single process
    flags             The command line of `swarm-up`, made from the description
    launch_arguments  The options of `swarm-up` as arguments of a ROS 2 launch file

May import swarm_common, swarm_mission, swarm_recording, swarm_setup; swarm_sim, swarm_nav and
swarm_central where the command line does not pass.
"""
