"""Terms that all parts of a navigator share: its parameters, goals, states and priorities.

What a module imports of its folder stands above it:

    rank                 The one order of all robots, who inherits whose rank, what rules may do
    goals                Goals that an operator sends, and the navigator's answers
    lifecycle            Lifecycle of a navigator as Nav2's lifecycle manager sees it, as a table
    limits               Limits of numbers, and choices of texts
    states               The navigator's states as a table
    localisation_config  Parameters of localisation, named as AMCL's
    config               Parameters of a navigator: each field is a ROS parameter
    plugins              Plug-ins of a navigator, and the built-in ones
    parameter_table      Unit, effect and range of each parameter

May import swarm_common only.
"""
