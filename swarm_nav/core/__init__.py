"""What every part of a navigator speaks of: its parameters, goals, states and priorities.

What a module imports of its folder stands above it:

    order_kernels        The one order of all robots, and what rules that only shape the flow may do
                         in it
    checks               Checks of numbers in a configuration; each raises ConfigError naming the
                         parameter
    goals                What an operator asks of a navigator, and what the navigator tells it in
                         return
    lifecycle            Lifecycle of a navigator as Nav2's lifecycle manager sees it, as a table
    limits               Between which values every number among a navigator's parameters lies
    priority             A robot's priority as one number: class, seniority, id, and the depth of
                         its inheritance
    states               The navigator's states as a table; docs/architecture/tick.md has the
                         diagram made from it
    localisation_config  Parameters of localisation: AMCL's where AMCL has them, and what a lost
                         robot is
    config               Parameters of a navigator. A field is a ROS parameter: `group.name`, the
                         controller's bare
    parameter_table      What each parameter of a navigator is: unit, effect, range; from the
                         comments of its class

May import swarm_common only.
"""
