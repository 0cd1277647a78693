"""A robot's priority as one number: class, seniority, id, and the depth of its inheritance.

From the highest bits down: the class, how long ago the last goal was reached, the id (so that no
two robots are equal), and the hops over which the priority was inherited, counted down.
"""

from __future__ import annotations

CLASS_DONE, CLASS_HOLDING, CLASS_DRIVING = 0, 1, 2
DEPTH_BITS, ID_BITS, TICK_BITS = 6, 10, 32
TOP_DEPTH = (1 << DEPTH_BITS) - 1  # also the mask of the depth
OWN_DEPTH = 32  # of a robot's own priority, for as many hops
OUT_OF_LANES = 30  # hops of a robot that leaves single lanes: all before it go out as well
ID_MASK = (1 << ID_BITS) - 1
SENIORITY = (1 << (TICK_BITS + ID_BITS + DEPTH_BITS)) - 1  # mask of all but the class


def base_priority(rank: int, last_goal_tick: int, robot_id: int) -> int:
    """Return the 50-bit priority: class, seniority, id, and depth for inheritance.

    Args:
        rank: `CLASS_DONE`, `CLASS_HOLDING` or `CLASS_DRIVING`.
        last_goal_tick: Tick at which the robot reached its last target; the earlier, the higher it
            ranks.
        robot_id: From 1; of otherwise equal robots the smaller id ranks higher.
    """
    seniority = (1 << TICK_BITS) - 1 - last_goal_tick
    value = (rank << TICK_BITS) | seniority
    value = (value << ID_BITS) | (ID_MASK - robot_id % (1 << ID_BITS))
    return (value << DEPTH_BITS) | OWN_DEPTH


def above(priority: int, hops: int = 0) -> int:
    """Return the priority of a robot for which others wait: as they drive, just above their own.

    Waiting robots are parked, below all driving ones; the robot that keeps them waiting must rank
    above both.

    Args:
        priority: Of a robot that waits, of any class.
        hops: How many robots that push one another on its behalf rank above those that inherit the
            same priority with none: who goes out has some, who goes in none.
    """
    driving = CLASS_DRIVING << (TICK_BITS + ID_BITS + DEPTH_BITS)
    return driving | (priority & SENIORITY & ~TOP_DEPTH) | (OWN_DEPTH + 1 + hops)
