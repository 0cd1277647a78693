"""The one order of all robots, and what rules that only shape the flow may do in it.

Single-lane passages, the gate and the right of way of a blocked robot's next metres compare ranks
here and nowhere else: each may hold up a robot for one that ranks above it, and for nobody while it
makes way. So waiting by a rule leads upwards in one order, has no circle, and the highest robot
waits for bodies and held space only.
"""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def outranks(theirs, their_id, own, own_id):
    """Whether a robot with the priority `theirs` ranks above one with `own`."""
    return theirs > own or (theirs == own and their_id < own_id)


@njit(cache=True)
def may_hold_up(theirs, their_id, is_gone, own):
    """Whether a rule may hold up `own` = (priority, id, yields for) for another robot."""
    priority, own_id, yields_for = own
    return yields_for == 0 and not is_gone and outranks(theirs, their_id, priority, own_id)
