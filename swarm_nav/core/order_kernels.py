"""The one order of all robots, and what rules that only shape the flow may do in it.

Requests for space, pushes, the gate, single-lane passages and the right of way of a blocked robot's
next metres compare ranks here. The last two hold up a robot for one that ranks above it only, and
for nobody while it drives to a refuge: so waiting by them leads upwards in one order, has no
circle, and never holds up the highest robot.
"""

from __future__ import annotations

from typing import NamedTuple

from swarm_common.process.numba_compat import njit


class Rank(NamedTuple):
    """Where a robot stands in the order."""

    priority: int
    id: int
    yields_for: int  # id of the robot that it makes way for, 0 for none


@njit(cache=True)
def outranks(theirs: int, their_id: int, own: int, own_id: int) -> bool:
    """Whether another robot ranks above this one; of equal priorities the smaller id does.

    Args:
        theirs: Priority of the other robot.
        their_id: Its id.
        own: Priority of this robot.
        own_id: Its id.
    """
    return theirs > own or (theirs == own and their_id < own_id)


@njit(cache=True)
def may_hold_up(theirs: int, their_id: int, is_gone: bool, own: Rank) -> bool:
    """Whether a rule may hold up this robot for another one.

    Args:
        theirs: Priority of the other robot.
        their_id: Its id.
        is_gone: Whether it is silent.
        own: Rank of this robot.
    """
    return own.yields_for == 0 and not is_gone and outranks(theirs, their_id, own.priority, own.id)
