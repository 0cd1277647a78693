"""What a robot does, tick by tick: goals, states, recoveries, and what it announces.

What a module imports of its folder stands above it:

    state_machine      The state that a robot is in, by the table of `states.py`, and what changing
                       it brings along
    behaviors          Behaviours beside navigation: spin, back up, drive on heading, wait; and
                       recoveries from them
    costmap            Costmaps with Nav2's cost scale, composed on request
    given_path         A path that the operator gave (FollowPath): how far the robot is on it, and
                       the way along it
    goal_progress      The current goal: its sequence of targets, and when each counts as reached
    announcement       What a robot tells: its beacon to the robots, its status and feedback to the
                       operator
    goal_manager       The pursuit of goals: begins them, goes from target to target, recovers, and
                       ends them
    route              The route to the current target: when it is replanned, and where the new one
                       starts
    behavior_executor  What the robot does in each state: which path it follows, and which twist
                       overrides that
    navigator          The brain of one robot: observations in, one twist and one beacon per tick
                       out. No I/O

May import of swarm_nav: `traffic`, `localisation`, `control`, `perception`, `planning`, `core`;
and swarm_common.
"""
