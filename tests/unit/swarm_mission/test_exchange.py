"""Who goes where when robots change places or roam."""

import pytest

from swarm_common.model.records import Pose
from swarm_mission.exchange import opposite, other_groups, roaming


@pytest.mark.parametrize("count", [1, 2, 3, 8, 20, 41])
def test_across_a_ring_everybody_gets_a_place_of_its_own(count):
    partners = opposite(count)
    assert sorted(partners) == list(range(count))
    assert all((partner - index) % count == count // 2 for index, partner in enumerate(partners))


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize(("count", "groups"), [(20, 2), (12, 2), (24, 4), (23, 4), (5, 3), (2, 2)])
def test_everybody_changes_the_group(count, groups, seed):
    partners = other_groups(count, groups, str(seed))
    assert sorted(partners) == list(range(count))
    assert all(partner % groups != index % groups for index, partner in enumerate(partners))


@pytest.mark.parametrize(("count", "groups"), [(1, 2), (3, 2), (21, 2), (4, 1)])
def test_where_not_all_can_change_the_places_are_still_different(count, groups):
    partners = other_groups(count, groups, "0")
    assert sorted(partners) == list(range(count))
    stay = [index for index, partner in enumerate(partners) if partner % groups == index % groups]
    assert len(stay) == (count if groups == 1 else 1)


def test_draws_follow_the_seed_and_take_the_farthest_place():
    assert other_groups(24, 4, "7") == other_groups(24, 4, "7")
    assert len({tuple(other_groups(24, 4, str(seed))) for seed in range(20)}) == 20
    (chosen,) = roaming(HOMES[:1], PLACES, 1, 100.0, "0")
    assert PLACES[chosen[0]] == Pose(5.0, 3.0, 0.0)


HOMES = tuple(Pose(float(x), 0.0, 0.0) for x in range(6))
PLACES = tuple(Pose(float(x), float(y), 0.0) for x in range(6) for y in range(1, 4))


@pytest.mark.parametrize("seed", range(20))
def test_roaming_robots_never_share_a_place_and_go_far(seed):
    rounds = roaming(HOMES, PLACES, 4, 2.5, str(seed))
    assert len(rounds) == 4
    last = list(HOMES)
    for chosen in rounds:
        assert len(set(chosen)) == len(HOMES)
        here = [PLACES[index] for index in chosen]
        assert all(a.distance(b) >= 2.5 for a, b in zip(last, here, strict=True))
        last = here
