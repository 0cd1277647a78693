"""Behaviour of a robot, tick by tick: goals, states, recoveries and announcements.

What a module imports of its folder stands above it:

    state_machine      The state that a robot is in, and what changing it brings along
    behaviors          Behaviours beside navigation (spin, back up, wait, ...), and recoveries
    costmap            Costmaps with Nav2's cost scale, composed on request
    given_path         A path that the operator gave (FollowPath), and the way along it
    goal_progress      The current goal: its sequence of targets, and when each counts as reached
    charging           Trips to charge: when, to which station, and until when
    goal_manager       Begins goals, goes from target to target, recovers, and ends them
    parts              The parts of one robot: rules decide with them, announcements tell of them
    announcement       Its beacon to the other robots, its status to the operator
    route              The route to the current target: when and from where it is replanned
    plugin_rule        A rule that a user brings, asked among the built-in ones
    rules              The rules in the order in which the arbiter asks them
    follow_centre      The rule of a robot for which a centre decides
    plugin_priority    A rule of who goes first that a user brings
    services           Commands of an operator and services of Nav2 for a navigator
    navigator          The brain: observations in, one twist and one beacon per tick out. No I/O
    plain              A brain without traffic: what baselines and brains of users have in common
    plugin_brain       The brain by `brain.plugin`: ours, or one that a user brings

May import of swarm_nav: `traffic`, `localisation`, `control`, `perception`, `planning`,
`interfaces`, `core`; and swarm_common.
"""
