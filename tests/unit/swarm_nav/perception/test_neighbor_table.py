"""Who is heard, how old that is, and the difference between having left and being gone."""

import numpy as np
import pytest

from swarm_common.model.beacon import (
    BEACON_DTYPE,
    FLAG_ACTIVE,
    FLAG_DEAF,
    FLAG_LEFT,
    FLAG_STUCK,
    HEARD_ENTRIES,
    SIGHTED_ASKS,
    SIGHTINGS,
    reception_of,
    word_of,
    words_of,
)
from swarm_nav.core.config import TrafficConfig
from swarm_nav.core.rank import DEPTH_BITS, base_priority
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.perception.neighbor_table_kernels import UNHEARD
from tests.fakes.navigation import beacon

LOST_TICKS = TrafficConfig().lost_ticks
SIGHTED = word_of("sighted_id")


def heard(neighbors, tick, *records):
    for record in records:
        record["tick"] = tick
    neighbors.receive(np.array(records), 0.0, 0.0)


def neighbors():
    return NeighborTable(1, TrafficConfig())


def test_rows_are_ordered_by_id_and_hold_the_newest_beacon():
    here = neighbors()
    heard(here, 10, beacon(7, 1.0, 0.0), beacon(3, 2.0, 0.0))
    heard(here, 11, beacon(7, 1.5, 0.0))
    here.refresh(12)
    assert here.ids.tolist() == [3, 7]
    assert here.ages.tolist() == [2, 1]
    assert here.beacons[1]["pose"][0] == pytest.approx(1.5)
    assert here.row(7) == 1
    assert here.row(99) is None


def test_who_was_last_heard_near_the_edge_of_the_range_may_have_left():
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0))
    here.refresh(26)
    assert here.ids.tolist() == [2]
    here.refresh(27)
    assert here.ids.tolist() == []
    listen(here, range(28, 500), 0.0)
    assert here.ids.tolist() == []  # nothing is learned from afar


def listen(here, ticks, x, *records):
    """Hear the same robots at each tick, from (x, 0)."""
    for tick in ticks:
        for record in records:
            record["tick"] = tick - 1
            record["heard"] = np.where(record["heard"] > 0, record["heard"] + 1, 0)
        here.receive(np.array(list(records), BEACON_DTYPE), x, 0.0)
        here.refresh(tick)
        assert all(len(here.tubes(row)) for row in range(len(here.ids)))  # each is somewhere


def telling(robot, x, other, tick, at):
    record = beacon(robot, x, 0.0)
    record["sighted_id"][1], record["sighted_tick"][1], record["sighted_at"][1] = other, tick, at
    return record


@pytest.mark.parametrize("last_heard", [4.4, 5.5])
def test_who_fell_silent_near_the_edge_and_is_near_is_gone(last_heard):
    here = neighbors()
    heard(here, 10, beacon(2, last_heard, 0.0, held=[(last_heard, 0.0), (last_heard, 0.1)]))
    here.refresh(27)
    listen(here, range(28, 90), 2.5)
    assert here.gone.tolist() == [True]
    assert len(here.tubes(0)) == 2
    listen(here, range(90, 200), -3.0)
    assert here.ids.tolist() == [2]
    listen(here, range(200, 201), -3.0, beacon(2, 1.0, 0.0))
    assert here.gone.tolist() == [False]


def test_who_was_seen_elsewhere_later_has_left():
    """A station counted as occupied for 1,034 s by a robot that had driven away unheard."""
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0))
    here.refresh(27)
    listen(here, range(28, 90), 2.5, beacon(3, 4.0, 0.0))
    assert here.gone.tolist() == [True, False]
    listen(here, range(90, 110), 2.5, telling(3, 4.0, 2, 40, (9.0, 3.0)))
    assert here.ids.tolist() == [3]
    listen(here, range(110, 800), 2.5, beacon(3, 4.0, 0.0))
    assert here.ids.tolist() == [3]


def test_who_was_seen_elsewhere_is_waited_for_there():
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0))
    here.refresh(27)
    listen(here, range(28, 60), -5.0, telling(3, -1.0, 2, 40, (2.0, 3.0)))
    listen(here, range(60, 120), 2.5)
    row = here.row(2)
    assert row is not None
    assert here.gone[row]
    assert here.tubes(row).tolist() == [[2.0, 3.0]]
    listen(here, range(120, 60 + 620), 2.5)
    assert 2 not in here.ids  # it went on from there


@pytest.mark.parametrize(
    ("tick", "at"),
    [(9, (9.0, 3.0)), (10, (9.0, 3.0)), (40, (5.5, 0.1))],
    ids=["before", "at the same time", "at its place"],
)
def test_what_others_remember_of_a_robot_does_not_show_that_it_left(tick, at):
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0))
    here.refresh(27)
    listen(here, range(28, 900), 2.5, telling(3, 4.0, 2, tick, at))
    assert here.ids.tolist() == [2, 3]
    assert here.gone.tolist() == [True, False]
    assert here.tubes(0).tolist() == [[5.5, 0.0]]


def test_who_stood_stays_and_who_drove_out_of_range_has_left():
    """It counted as left after a minute if the listener had driven away from it."""
    here = neighbors()
    for tick in range(10, 20):
        here.receive(np.array([beacon(2, 5.7, 0.0, tick=tick)]), -0.03 * (tick - 10), 0.0)
        here.refresh(tick + 1)
    listen(here, range(20, 1500), 2.5)
    assert here.gone.tolist() == [True]
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0, held=[(5.5, 0.0), (5.9, 0.0)], wanted=[(6.1, 0.0)]))
    here.refresh(27)
    listen(here, range(28, 600), 2.5)
    assert here.gone.tolist() == [True]
    listen(here, range(600, 660), 2.5)
    assert here.ids.tolist() == []


def test_what_is_known_of_robots_is_passed_on():
    """Robot 4 never met those that robot 1 met, and is told of each within a round."""
    first, second = neighbors(), NeighborTable(4, TrafficConfig())
    met = [beacon(robot, 1.0, float(robot)) for robot in (200, 2, 90)]
    met[1]["station_tick"] = 8  # robot 2 has asked for a station
    heard(first, 10, *met)
    first.refresh(11)
    told = set()
    for tick in range(300, 304):
        record = beacon(1, 0.0, 0.0, tick=tick)
        words = words_of(np.array([record]))
        words[0, SIGHTED:] = first.sighted(tick)
        second.receive(words.view(BEACON_DTYPE)[:, 0], 3.0, 0.0)
        second.refresh(tick)
        shown = words.view(BEACON_DTYPE)[0, 0]
        told |= {
            (int(robot), int(when), *map(float, at))
            for robot, when, at in zip(
                shown["sighted_id"], shown["sighted_tick"], shown["sighted_at"], strict=True
            )
        }
    asking = 2 | SIGHTED_ASKS
    assert told == {(200, 10, 1.0, 200.0), (asking, 10, 1.0, 2.0), (90, 10, 1.0, 90.0)}
    again = {int(robot) for tick in range(4) for robot in second.sighted(tick)[:SIGHTINGS]}
    assert again == {1, asking, 90, 200}
    assert np.flatnonzero(second.sightings.asks).tolist() == [2]
    assert not neighbors().sighted(7).any()


def test_who_fell_silent_near_here_and_was_seen_elsewhere_later_has_left():
    """A robot hung for some seconds, went on unheard, and was an obstacle where it had hung."""
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0, held=[(1.0, 0.0), (1.2, 0.0)]))
    listen(here, range(27, 700), 0.0, telling(3, 4.0, 2, 300, (1.3, 0.0)))
    assert here.ids.tolist() == [2, 3]
    assert len(here.tubes(0)) == 2  # nobody saw it elsewhere, however long that is ago
    listen(here, range(700, 710), 0.0, telling(3, 4.0, 2, 400, (9.0, 0.0)))
    assert here.ids.tolist() == [3]
    listen(here, range(710, 760), 6.0, beacon(3, 4.0, 0.0))
    assert here.tubes(0).tolist() == [[9.0, 0.0]]  # it is waited for there
    listen(here, range(760, 765), 6.0, beacon(2, 9.0, 0.0))
    assert not here.gone[0]


def test_a_place_that_was_given_up_in_part_is_compared_as_a_whole():
    """It stopped at the end of its space; that it was at the beginning before shows nothing."""
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0, held=[(1.0, 0.0), (1.35, 0.0)]))
    listen(here, range(27, 120), 1.0)  # this robot is where the space began
    assert np.allclose(here.tubes(0), [(1.35, 0.0)])
    listen(here, range(120, 200), 1.0, telling(3, 4.0, 2, 12, (1.05, 0.0)))
    assert np.allclose(here.tubes(0), [(1.35, 0.0)])


def test_that_a_robot_was_taken_out_of_the_world_is_passed_on_and_shows_no_place():
    """The farewell has the pose (0, 0): there it was waited for by who had not heard it."""
    first, here = NeighborTable(3, TrafficConfig()), neighbors()
    listen(here, range(10, 11), 0.0, beacon(2, 5.5, 0.0))
    listen(first, range(30, 31), 0.0, beacon(2, 0.0, 0.0, flags=FLAG_LEFT))
    for tick in range(31, 200):
        record = beacon(3, -1.0, 0.0)
        words = words_of(np.array([record]))
        words[0, SIGHTED:] = first.sighted(tick)
        listen(here, range(tick, tick + 1), 2.5, words.view(BEACON_DTYPE)[0, 0])
    assert here.ids.tolist() == [3]


def test_who_was_taken_out_of_the_world_and_came_back_is_known_by_its_new_place():
    first, here = NeighborTable(3, TrafficConfig()), neighbors()
    listen(here, range(10, 11), 0.0, beacon(2, 5.5, 0.0))
    listen(first, range(30, 80), 0.0, beacon(2, 0.0, 0.0, flags=FLAG_LEFT))
    listen(first, range(80, 90), 0.0, beacon(2, 3.0, 1.0))
    for tick in range(90, 160):
        record = beacon(3, -1.0, 0.0)
        words = words_of(np.array([record]))
        words[0, SIGHTED:] = first.sighted(tick)
        listen(here, range(tick, tick + 1), 2.5, words.view(BEACON_DTYPE)[0, 0])
    assert here.tubes(0).tolist() == [[3.0, 1.0]]


def test_what_is_known_does_not_depend_on_the_order_of_beacons_or_batches():
    records = [telling(robot, 4.0, 9, 30 + robot % 3, (robot, 2.0)) for robot in (3, 4, 5, 6)]
    records.append(telling(7, 4.0, 3, 12, (5.0, 5.0)))
    seen = []
    for split, order in ((5, 1), (2, 1), (3, -1), (0, -1)):
        here = neighbors()
        heard(here, 10, beacon(9, 5.5, 0.0))
        here.refresh(27)
        for part in (records[:split], records[split:]):
            heard(here, 40, *part[::order])
        here.refresh(41)
        listen(here, range(42, 120), 2.5)
        told = [here.sighted(tick).tobytes() for tick in range(9)]
        seen.append((told, here.ids.tolist(), [here.tubes(row).tolist() for row in range(6)]))
    assert all(other == seen[0] for other in seen)


@pytest.mark.parametrize("robot", [0x7F, 0x80, 0xFFFF])
def test_robots_of_any_id_are_passed_on(robot):
    here = neighbors()
    listen(here, range(10, 12), 0.0, telling(3, 4.0, robot, 5, (1.0, 2.0)))
    told = {int(k) for tick in range(2) for k in here.sighted(tick)[:SIGHTINGS]}
    assert told == {3, robot}


def test_who_was_taken_out_or_overtaken_is_not_waited_for():
    here = neighbors()
    heard(here, 10, beacon(2, 5.5, 0.0))
    here.refresh(27)
    listen(here, range(28, 30), 0.0, beacon(2, 0.0, 0.0, flags=FLAG_LEFT))
    listen(here, range(30, 100), 2.5)
    assert here.ids.tolist() == []
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0))
    heard(here, 8, beacon(2, 2.0, 0.0))
    here.refresh(11)
    assert here.ages.tolist() == [1]
    assert here.beacons[0]["pose"][0] == 1.0


def test_a_silent_robot_is_not_where_somebody_else_is():
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0, held=[(1.0, 0.0), (1.05, 0.0), (1.2, 0.0)]))
    here.refresh(27)
    listen(here, range(105, 125), 0.0, beacon(3, 1.0, 0.0))
    assert np.allclose(here.tubes(0), [(1.2, 0.0)])
    listen(here, range(125, 140), 1.2)
    assert here.ids.tolist() == [3]


def test_who_falls_silent_well_inside_is_gone_until_heard_again():
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0, held=[(1.0, 0.0)], wanted=[(1.05, 0.0), (1.1, 0.0)]))
    here.refresh(26)
    assert not here.gone.any()
    assert len(here.tubes(0)) == 1
    here.refresh(27)
    assert here.gone.tolist() == [True]
    assert here.stuck.tolist() == [True]
    assert len(here.tubes(0)) == 3
    here.refresh(5000)
    assert here.ids.tolist() == [2]
    here = neighbors()
    heard(here, 10, beacon(2, 1.0, 0.0))
    here.refresh(100)
    heard(here, 100, beacon(2, 1.0, 0.0))
    here.refresh(101)
    assert here.gone.tolist() == [False]


def test_stuck_and_immovable_are_told_apart():
    here = neighbors()
    heard(here, 1, beacon(2, 1.0, 0.0), beacon(3, 1.0, 2.0, flags=FLAG_STUCK | FLAG_ACTIVE))
    here.refresh(2)
    assert here.stuck.tolist() == [False, True]
    here = neighbors()
    heard(here, 1, beacon(2, 1.0, 0.0))
    heard(here, 40, beacon(3, 1.0, 2.0, flags=0), beacon(4, 1.0, 3.0))
    here.refresh(41)
    assert here.immovable.tolist() == here.stuck.tolist() == [True, True, False]


def test_priorities_of_any_number_of_robots_are_remembered_and_an_empty_batch_is_taken():
    here = neighbors()
    priority = (2 << 48) | (0xFFFFFFFF << 16) | 5
    heard(here, 1, beacon(2, 1.0, 0.0, priority=priority))
    here.refresh(2)
    assert here.priorities.tolist() == [priority]
    here = neighbors()
    heard(here, 1, *(beacon(number, 1.0, 0.0) for number in range(2, 150)))
    here.refresh(2)
    assert here.ids.tolist() == list(range(2, 150))
    here = neighbors()
    heard(here, 1, beacon(2, 1.0, 0.0))
    here.receive(np.zeros(0, beacon(1, 0.0, 0.0).dtype), 0.0, 0.0)
    here.refresh(3)
    assert here.ages.tolist() == [2]


def test_what_the_others_have_is_read_from_their_acknowledgements():
    here = neighbors()
    heard(
        here, 70_000, acknowledging(2, 69_998), acknowledging(3, 69_000),
        beacon(4, 1.0, 0.0), beacon(5, 1.0, 0.0, flags=FLAG_ACTIVE | FLAG_DEAF),
    )  # fmt: skip
    here.refresh(70_001)
    assert here.acks.tolist() == [69_998, 69_000, UNHEARD, 70_001]
    here.refresh(70_100)
    assert here.acks.tolist() == [70_100] * 4  # gone: they cannot answer


def test_the_nearest_robots_are_acknowledged_and_the_others_in_turn():
    here = neighbors()
    heard(here, 7, *(beacon(k, 0.1 * k, 0.0) for k in range(2, 72)))
    here.refresh(8)
    seen = {int(entry) >> 16 for entry in here.heard(8)}
    assert set(range(2, 42)) <= seen
    assert all(int(entry) & 0xFFFF == 7 for entry in here.heard(8))
    for tick in range(9, 13):
        seen |= {int(entry) >> 16 for entry in here.heard(tick)}
    assert seen == set(range(2, 72))


@pytest.mark.parametrize(
    ("distance", "acknowledged", "stands"),
    [(1.5, 70, False), (1.5, 50, True), (5.5, 50, True), (5.7, 50, False)],
)
def test_who_is_not_heard_by_a_near_robot_notices(distance, acknowledged, stands):
    here = neighbors()
    for tick in range(50, 101, 10):
        heard(here, tick, acknowledging(2, acknowledged, distance))
        here.refresh(tick + 1)
    assert (here.deaf_neighbor == 2) is stands


def test_a_robot_that_does_not_hear_is_noticed_though_another_does():
    here = neighbors()
    for tick in range(50, 101, 10):
        heard(here, tick, acknowledging(2, 50, 3.0), acknowledging(3, tick - 1, 3.0))
        here.refresh(tick + 1)
    assert here.deaf_neighbor == 2


def test_a_robot_that_is_acknowledged_in_turn_is_heard():
    """It stood for good in a crowd: one of 49 neighbours had no room for it in each tick."""
    crowd, here = NeighborTable(2, TrafficConfig()), neighbors()
    others = [beacon(robot, 0.05 * robot, 0.0) for robot in range(3, 63)]
    for tick in range(1, 100):
        heard(crowd, tick, beacon(1, 5.0, 0.0), *others)
        crowd.refresh(tick + 1)
        answer = beacon(2, 5.0, 0.0)
        answer["heard"] = crowd.heard(tick + 1)
        heard(here, tick + 1, answer)
        here.refresh(tick + 1)
        if tick > LOST_TICKS:
            assert here.acks[0] >= tick - LOST_TICKS
            assert here.deaf_neighbor == 0


@pytest.mark.parametrize(
    ("listed", "later", "known"),
    [
        (HEARD_ENTRIES, 5, True),
        (HEARD_ENTRIES, LOST_TICKS + 3, False),
        (HEARD_ENTRIES - 1, 1, False),
    ],
)
def test_an_acknowledgement_lasts_for_a_turn_of_a_full_list(listed, later, known):
    here = neighbors()
    heard(here, 50, acknowledging(2, 49))
    silent = beacon(2, 1.0, 0.0)
    silent["heard"][:listed] = [robot << 16 | 40 for robot in range(3, 3 + listed)]
    heard(here, 50 + later, silent)
    here.refresh(51 + later)
    assert here.acks.tolist() == [49 if known else UNHEARD]


def acknowledging(robot, tick, x=1.0):
    record = beacon(robot, x, 0.0)
    record["heard"][3] = 1 << 16 | (tick & 0xFFFF)
    return record


def test_the_highest_of_those_that_were_blocked_for_long_enough_pushes():
    here = neighbors()

    def blocked(robot, priority, ticks, by=1):
        record = beacon(robot, 1.0, 0.0, priority=priority)
        record["blocked_by"], record["blocked_ticks"] = by, ticks
        return record

    assert here.highest_pusher(5, 3) is None
    helping = blocked(9, 99, 9)
    helping["yields_for"] = 1
    heard(here, 1, blocked(2, 7, 3), blocked(3, 9, 3), blocked(4, 9, 9), blocked(5, 99, 2),
          blocked(6, 99, 9, by=7), blocked(8, 4, 9), blocked(10, 1 << DEPTH_BITS, 9),
          helping)  # fmt: skip  # 10 is at the end of a chain
    here.refresh(2)
    assert here.highest_pusher(5, 3) == 1  # of equals the smaller id
    assert here.highest_pusher(9, 3) is None  # those of equal rank have larger ids
    assert here.highest_pusher(3, 9) == 2
    here.refresh(40)
    assert here.highest_pusher(5, 3) is None  # all are gone


@pytest.mark.parametrize("own_id", [1, 9])
def test_of_two_robots_that_inherited_one_rank_the_smaller_id_pushes_at_once(own_id):
    here = NeighborTable(own_id, TrafficConfig())
    record = beacon(5, 1.0, 0.0, priority=9)
    record["blocked_by"], record["blocked_ticks"] = own_id, 3
    heard(here, 1, record)
    here.refresh(2)
    assert here.highest_pusher(9, 3) == (0 if own_id == 9 else None)


def test_earlier_requests_for_the_same_station_count():
    here = NeighborTable(5, TrafficConfig())

    def asking(robot, tick, x):
        record = beacon(robot, 1.0, 0.0)
        record["station"], record["station_tick"] = (x, 0.0), tick
        return record

    heard(here, 20, asking(2, 10, 3.0), asking(3, 12, 3.0), asking(4, 11, 3.3), asking(6, 12, 3.0),
          asking(7, 3, 5.0), asking(8, 0, 3.0), asking(9, 11, np.nan))  # fmt: skip
    here.refresh(21)
    assert here.queue(np.array(((3.0, 0.0),)), 12, 0.6)[:2] == (3, 2)
    assert here.queue(np.array(((3.0, 0.0),)), 10, 0.6)[:2] == (1, 2)
    assert here.queue(np.array(((5.0, 0.0),)), 9, 0.6)[:2] == (1, 7)
    assert here.queue(np.array(((9.0, 0.0),)), 9, 0.6)[:2] == (0, 0)
    assert here.queue(np.array(((3.0, 0.0), (5.0, 0.0))), 12, 0.6)[:2] == (4, 7)


def test_the_highest_that_waits_for_a_station_counts():
    here = neighbors()

    def asking(robot, tick, x, priority):
        record = beacon(robot, 1.0, 0.0, priority=priority)
        record["station"], record["station_tick"] = (x, 0.0), tick
        return record

    own = [base_priority(2, 100 - robot, robot) for robot in range(6)]
    assert here.queue(np.array(((3.0, 0.0),)), 9, 0.6)[2] == 0
    heard(here, 20, asking(2, 10, 3.0, own[2]), asking(3, 12, 3.3, own[3]),
          asking(4, 0, 3.0, own[4]), asking(5, 9, 5.0, own[5]))  # fmt: skip
    here.refresh(21)
    assert here.queue(np.array(((3.0, 0.0),)), 9, 0.6)[2] == own[3]
    # who was pushed by the holder of the station must not lend it its own priority back
    heard(here, 21, asking(3, 12, 3.3, base_priority(2, 50, 9) - 1))
    here.refresh(22)
    assert here.queue(np.array(((3.0, 0.0),)), 9, 0.6)[2] == own[2]
    here.refresh(60)
    assert here.queue(np.array(((3.0, 0.0),)), 9, 0.6)[2] == 0


@pytest.mark.parametrize("removed", [2, 5, 9])
def test_who_was_taken_out_of_the_world_is_forgotten_at_once(removed):
    here = neighbors()
    heard(here, 10, *[beacon(robot, 0.25 * robot, 0.0) for robot in (2, 5, 9)])
    here.refresh(60)
    assert here.gone.all()
    farewell = beacon(removed, 0.0, 0.0)
    farewell["flags"] = FLAG_LEFT
    stranger = beacon(7, 0.0, 0.0)
    stranger["flags"] = FLAG_LEFT
    batch = sorted([farewell, stranger, beacon(6, 2.5, 0.0)], key=lambda record: record["id"])
    heard(here, 60, *batch)
    here.refresh(61)
    left = sorted({2, 5, 6, 9} - {removed})
    assert here.ids.tolist() == left
    assert here.beacons["pose"][:, 0].tolist() == [2.5 if i == 6 else 0.25 * i for i in left]
    heard(here, 62, beacon(removed, 3.0, 0.0))
    here.refresh(63)
    assert not here.gone[here.row(removed)]


def test_points_are_kept_when_what_was_on_the_air_is_not():
    here = neighbors()
    past: list[np.ndarray] = []
    tubes = {robot: [(0.1 * k, float(robot)) for k in range(robot)] for robot in (3, 5, 8)}
    for tick, audible in ((10, (3, 5, 8)), (11, (5,)), (12, (8,)), (13, ())):
        records = [beacon(i, 0.0, float(i), held=tubes[i], tick=tick) for i in audible]
        on_the_air = reception_of(np.array(records, beacon(1, 0.0, 0.0).dtype))
        here.take(on_the_air, 0.0, 0.0)
        here.refresh(tick + 1)
        if tick == 11:
            assert len(here.beacons) == 3  # all are looked at, from the table on
        if audible:
            past.append(on_the_air.words)
            for words in past[:-1]:
                words[:] = 0
    for row, robot in enumerate((3, 5, 8)):
        assert np.allclose(here.tubes(row), tubes[robot])
