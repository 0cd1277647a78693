"""Rules that only shape the flow hold up robots for higher ones only: so they have no circle."""

import itertools

from swarm_nav.core.rank import Rank, may_hold_up, outranks

ROBOTS = [(priority, robot) for priority in (3, 5, 5, 9) for robot in (1, 2, 7)]


def test_one_ranks_above_the_other_and_holds_up_nobody_higher():
    for (one, a), (two, b) in itertools.combinations(set(ROBOTS), 2):
        assert a == b or outranks(one, a, two, b) != outranks(two, b, one, a)
    for (own, a), (theirs, b) in itertools.permutations(set(ROBOTS), 2):
        assert may_hold_up(theirs, b, False, Rank(own, a, 0)) == outranks(theirs, b, own, a)
        assert not may_hold_up(theirs, b, True, Rank(own, a, 0))
        assert not may_hold_up(theirs, b, False, Rank(own, a, 4))
