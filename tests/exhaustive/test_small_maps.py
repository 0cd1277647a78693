"""Every placement of few robots on small maps: all arrive, nobody touches.

A sample of them runs always, every one with `-m long` (hours) or `python -m tests.exhaustive`.
"""

import itertools

import pytest

from tests.fakes.cells import (
    AISLE,
    ALCOVE,
    CORNER,
    DOOR,
    EIGHT,
    MAPS,
    PAIR,
    PAIR_IN_ALCOVE,
    RING,
    SMALL_CORNER,
    SMALL_DOOR,
    SMALL_TREE,
    TREE,
    TWIGS,
    Placement,
    play,
)  # fmt: skip

HELD_GAP = 0.5  # [m] that two held tubes keep at least, whatever happens
ONE_LANE = (ALCOVE, TREE, TWIGS, SMALL_TREE)  # where four robots may have no room to change places
CASES = [(cells, count) for cells in MAPS for count in ((2, 3) if cells in ONE_LANE else (2, 3, 4))]
SAMPLES = 4  # placements per case that run always
COUNTS = {  # placements, one per symmetry
    (RING, 1): 10, (RING, 2): 210, (RING, 3): 2388,
    (AISLE, 1): 16, (AISLE, 2): 416, (AISLE, 3): 4704,
    (EIGHT, 1): 47, (EIGHT, 2): 3094,
    (DOOR, 2): 3136, (ALCOVE, 2): 882, (CORNER, 2): 4382, (TREE, 2): 824, (TWIGS, 2): 2042,
    (SMALL_DOOR, 2): 882, (SMALL_CORNER, 2): 794, (SMALL_TREE, 2): 236, (SMALL_TREE, 3): 1866,
    (PAIR, 2): 264, (PAIR, 3): 1760, (PAIR_IN_ALCOVE, 2): 144, (PAIR_IN_ALCOVE, 3): 672,
}  # fmt: skip


def ends_well(cells, placement):
    end = play(cells, placement)
    assert end.is_done, (cells.name, placement, end)
    assert end.contacts == 0, (cells.name, placement, end)
    assert end.gap >= HELD_GAP, (cells.name, placement, end)


@pytest.mark.parametrize(("cells", "count"), list(COUNTS), ids=lambda value: str(value)[:24])
def test_all_placements_are_counted_once(cells, count):
    placements = list(cells.placements(count))
    assert len(placements) == len(set(placements)) == COUNTS[cells, count]


@pytest.mark.timeout(300)
@pytest.mark.parametrize(("cells", "count"), CASES, ids=lambda value: str(value)[:24])
def test_all_arrive_from_a_sample_of_placements(cells, count):
    if len(cells.free) > 8 and count > 2:
        placements = list(itertools.islice(cells.placements(count), 20_000, 20_000 + SAMPLES))
    else:
        everything = list(cells.placements(count))
        placements = everything[count :: len(everything) // SAMPLES + 1]
    for placement in placements:
        ends_well(cells, placement)


def test_a_sample_has_distinct_starts_and_its_conditions_are_told():
    for placement in PAIR_IN_ALCOVE.sample(3, 20, 0):
        starts, goals = zip(*placement, strict=True)
        assert len(set(starts)) == 3
        assert set(goals) <= set(PAIR_IN_ALCOVE.stations)
        in_alcove = goals.count(PAIR_IN_ALCOVE.stations[0])
        assert PAIR_IN_ALCOVE.conditions(placement).is_guaranteed == (in_alcove < 2)


def test_a_picture_shows_robots_and_goals():
    placement: Placement = (((0, 2), (1, 5)), ((1, 2), (1, 0)))
    assert ALCOVE.picture(placement, [ALCOVE.pose(start) for start, _ in placement]) == "\n".join(
        (
            "+------------------------+",
            "|  b       2           a |",
            "|                        |",
            "|########  1 ############|",
            "|########    ############|",
            "+------------------------+",
        )
    )


@pytest.mark.timeout(300)
def test_seven_robots_change_places_on_the_eight_cells_of_the_ring():
    cells = RING.free[:7]
    ends_well(RING, tuple(zip(cells, (*cells[1:], cells[0]), strict=True)))


@pytest.mark.long
@pytest.mark.timeout(36_000)
@pytest.mark.parametrize(
    ("cells", "count"),
    [(RING, 2), (RING, 3), (RING, 4), (AISLE, 2), (AISLE, 3), (EIGHT, 2)],
    ids=lambda value: str(value)[:24],
)
def test_all_arrive_from_every_placement(cells, count):
    for placement in cells.placements(count):
        ends_well(cells, placement)
