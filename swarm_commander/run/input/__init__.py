"""Input of a run: options, parameter files, and the plan that follows from them.

What a module imports of its folder stands above it:

    flat          Parameters under dotted names, as ROS 2 counts them, and nested, as files have
                  them
    fleet_link    How the robots reach a fleet control of another maker
    options       Options of `swarm-up`, checked once
    world_params  The section `/world:` of a --params file: radio, engine, robots that are broken
    params        Parameter files of the navigators: defaults, the robot's data, the user's
                  overrides
    plan          Everything that is checked and loaded before a run starts a single process

May import of swarm_commander: `mission`, `viewers`; and swarm_common.
"""
