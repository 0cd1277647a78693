"""The one order of all robots: a rank as one number, who inherits whose, and what rules may do.

A priority is, from the highest bits down: the class, how long ago the last goal was reached, the id
(so that no two robots are equal), and the hops over which it was inherited, counted down. A robot
has its own one, or the highest that is passed on to it less one hop: by a robot that it keeps
waiting, or that it follows (`Donations`).

Requests for space, pushes, the gate, single-lane passages and the right of way of a blocked robot's
next metres compare ranks here. The last two hold up a robot for one that ranks above it only, and
for nobody while it drives to a refuge: so waiting by them leads upwards in one order, has no
circle, and never holds up the highest robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from swarm_common.process.numba_compat import njit

CLASS_DONE, CLASS_HOLDING, CLASS_DRIVING = 0, 1, 2
DEPTH_BITS, ID_BITS, TICK_BITS = 6, 10, 32
TOP_DEPTH = (1 << DEPTH_BITS) - 1  # also the mask of the depth
OWN_DEPTH = 32  # of a robot's own priority, for as many hops
OUT_OF_LANES = 30  # hops of a robot that leaves single lanes: all before it go out as well
ID_MASK = (1 << ID_BITS) - 1
SENIORITY = (1 << (TICK_BITS + ID_BITS + DEPTH_BITS)) - 1  # mask of all but the class


class Rank(NamedTuple):
    """Priority and id of a robot, and the robot that it makes way for."""

    priority: int
    id: int
    yields_for: int  # id of the robot that it makes way for, 0 for none


@dataclass(slots=True)
class Donations:
    """Priorities that are passed on to one robot, 0 for none; each has one writer at a time."""

    station: int = 0  # of robots that wait until it has left, by `Lease`, else by `Departure`
    lane: int = 0  # of a robot that it follows through a single lane, by `SingleLanes`
    push: int = 0  # of the robot whose way it bars, by `RightOfWay`
    yields_for: int = 0  # id of the robot that it makes way for, 0 for none; likewise

    def own(self, base: int) -> int:
        """Return the rank by which a robot asks who may push it.

        Args:
            base: Its `base_priority`.
        """
        return max(base, self.station, self.lane)

    def published(self, base: int) -> int:
        """Return the rank that others see.

        Args:
            base: Its `base_priority`.
        """
        return max(self.own(base), self.push)


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


@njit(cache=True)
def passed_on(priority: int) -> int:
    """Return the priority that a robot passes on when it follows or pushes: one hop less."""
    return priority - 1


def inherited_by_holder(priority: int, hops: int = 0) -> int:
    """Return the priority that a waiting robot passes on to the holder: as it drives, just above.

    Waiting robots are parked, below all driving ones; the robot that keeps them waiting must rank
    above both.

    Args:
        priority: Priority of a robot that waits, of any class.
        hops: Number of robots, each pushed by the one before on its behalf, that rank above those
            that inherit the same priority with none: who goes out has some, who goes in none.
    """
    driving = CLASS_DRIVING << (TICK_BITS + ID_BITS + DEPTH_BITS)
    return driving | (priority & SENIORITY & ~TOP_DEPTH) | (OWN_DEPTH + 1 + hops)


@njit(cache=True)
def outranks(theirs: int, their_id: int, own: int, own_id: int) -> bool:
    """Whether another robot ranks above this one; of equal priorities the smaller id does.

    Args:
        theirs: Priority of the other robot.
    """
    return theirs > own or (theirs == own and their_id < own_id)


@njit(cache=True)
def may_hold_up(theirs: int, their_id: int, is_gone: bool, own: Rank) -> bool:
    """Whether a rule may hold up this robot for another one.

    Args:
        theirs: Priority of the other robot.
        is_gone: Whether it is silent.
    """
    return own.yields_for == 0 and not is_gone and outranks(theirs, their_id, own.priority, own.id)
