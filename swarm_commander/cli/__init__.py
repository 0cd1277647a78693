"""The commands.

What a module imports of its folder stands above it:

    teleop_command     The command `swarm-teleop`: drives a robot of a running swarm by hand
    command_node       The node of a command that works with a running swarm; completions
    doctor             Is this machine fit for a swarm? If not, what to change; `swarm-setup`
    session            A session of `swarm-up`: from a checked plan to report and exit code
    child              The process that runs a swarm for a program, and ends with it
    thing_request      The request with which `swarm-commander spawn` adds an object to the world
    commander_command  The command `swarm-commander`: drives robots of a running swarm
    fleet_command      `swarm-commander spawn`, `remove`, `move`, `list` and the like
    up_command         The command `swarm-up`: its options
    main               Entry points of the commands `swarm-up`, `swarm-commander` and `swarm-report`

May import of swarm_commander: `hosts`, `run`, `mission`, `viewers`; swarm_run and swarm_common.
"""
