"""The held tube: bookkeeping of claim and request."""

import numpy as np
import pytest

from swarm_common.model.beacon import HELD_POINTS, INTENT_POINTS, WANTED_POINTS
from swarm_common.model.records import Pose
from swarm_nav.core.config import TrafficConfig
from swarm_nav.reservation.tube import REMEMBERED, TOLERANCE, Tube, padded

HOME = Pose(0.0, 0.0, 0.0)


def tube_along_x(length=2.0, confirmations=3):
    tube = Tube(HOME, confirmations, 0.35, 0.35)
    tube.adopt(np.column_stack((np.arange(0.0, length, 0.05), np.zeros(round(length / 0.05)))))
    return tube


def test_a_new_tube_holds_its_place_until_confirmed_as_often_as_said():
    tube = Tube(HOME, 3, 0.35, 0.35)
    held, wanted, intent = tube.publish(HOME, 0)
    assert held.tolist() == [[0.0, 0.0]]
    assert len(wanted) == 0
    assert len(intent) == 1
    assert tube.is_complete
    tube = tube_along_x()
    for _ in range(3):
        assert tube.span[2] == -1
        tube.publish(HOME, 0)
    assert tube.span == (0, 7, 7)
    tube = tube_along_x(confirmations=5)
    for count in range(5):
        assert tube.span[2] == -1, count
        tube.publish(HOME, 0)
    assert tube.span[2] == 7


@pytest.mark.parametrize("change", ["withdraw", "adopt", "cut", "release", "reset"])
def test_a_withdrawn_or_changed_request_starts_the_count_again(change):
    tube = tube_along_x()
    tube.stop = 1
    for _ in range(3):
        tube.publish(HOME, 0)
    match change:
        case "withdraw":
            tube.withdraw()
            _, wanted, _ = tube.publish(HOME, 0)
            assert len(wanted) == 0
        case "adopt":
            tube.adopt(np.array(((0.0, 0.0), (0.0, 0.05), (0.0, 0.1))))
        case "cut":
            tube.cut()
        case "release":
            tube.release_beyond(0)
        case "reset":
            tube.reset(HOME)
    assert tube.span[2] == -1
    for _ in range(2):
        tube.publish(HOME, 0)
        assert tube.span[2] == -1


def test_a_plan_continues_from_the_stop_point_and_keeps_what_is_held():
    tube = tube_along_x()
    tube.stop = 5
    tube.tail = tube.near = 2
    tube.adopt(np.array(((0.25, 0.0), (0.25, 0.05), (0.25, 0.1))))
    assert (tube.tail, tube.near, tube.stop) == (0, 0, 3)
    assert np.allclose(tube.points[[0, 3, 5]], ((0.10, 0.0), (0.25, 0.0), (0.25, 0.1)))
    assert tube.stop_point == pytest.approx((0.25, 0.0))


def test_plans_are_cut_and_released_space_never_grows():
    tube = tube_along_x()
    tube.stop = 5
    tube.cut()
    assert len(tube.points) == 6
    assert tube.is_complete
    tube = tube_along_x()
    tube.near, tube.stop = 2, 9
    tube.release_beyond(5)
    assert tube.stop == 5
    tube.release_beyond(32)
    assert tube.stop == 5


def test_the_beacon_has_the_held_path_and_fits_its_arrays():
    tube = tube_along_x(6.0)
    tube.tail, tube.near, tube.stop = 3, 3, 19
    held, wanted, intent = tube.publish(Pose(0.16, 0.01, 0.0), 0)
    assert np.allclose(held, tube.points[3:20])
    assert np.allclose(wanted[0], (1.0, 0.0))
    assert len(held) <= HELD_POINTS
    assert len(wanted) <= WANTED_POINTS
    assert len(intent) == INTENT_POINTS
    assert np.allclose(np.diff(intent, axis=0), (0.1, 0.0))


def test_a_robot_pushed_or_put_elsewhere_is_a_point_of_its_path():
    tube = tube_along_x()
    tube.stop = 5
    for aside, is_out in ((TOLERANCE - 0.001, False), (TOLERANCE + 0.001, True)):
        held, _, _ = tube.publish(Pose(0.1, aside, 0.0), 0)
        assert len(held) == 6 + is_out
        assert np.allclose(held[-6:], tube.points[:6])
    assert held[0] == pytest.approx((0.1, aside))
    tube = tube_along_x()
    tube.tail, tube.near, tube.stop = 1, 3, 5
    tube.shrink_to_place(Pose(0.16, 0.03, 0.0))
    assert np.allclose(tube.points, ((0.16, 0.0),))
    tube.shrink_to_place(Pose(0.16, 0.06, 0.0))
    assert np.allclose(tube.points, ((0.16, 0.0),))


def test_a_robot_that_stands_on_its_stop_holds_that_place_only():
    tube = tube_along_x()
    tube.stop = tube.near = 5
    tube.record_rest(Pose(0.21, 0.01, 0.0), is_standing=True)
    assert not tube.is_at_rest
    assert len(tube.publish(Pose(0.21, 0.01, 0.0), 0)[0]) == 6
    tube.record_rest(Pose(0.23, 0.01, 0.0), is_standing=False)
    assert not tube.is_at_rest
    tube.record_rest(Pose(0.23, 0.01, 0.0), is_standing=True)
    assert tube.is_at_rest
    assert np.allclose(tube.publish(Pose(0.23, 0.01, 0.0), 0)[0], ((0.25, 0.0),))


def test_the_nearest_point_is_that_of_the_path_also_while_it_follows_the_robot():
    tube = tube_along_x()
    tube.stop = 5
    for x, near in ((0.02, 0), (0.03, 1), (0.07, 1), (0.08, 2)):
        pose = Pose(x, 0.0, 0.0)
        tube.advance(pose, tube.stop)
        assert tube.near == near
        tail = int(x / 0.05)
        tube.points[tail] = (x, 0.0)  # as the stop filter does
        tube.follow_robot(tail)


def test_what_is_held_fits_the_beacon():
    tube = tube_along_x()
    tube.near = tube.stop = 20  # it stands, and does not give up what is behind it
    assert tube.span[1] == HELD_POINTS - 2
    longest = TrafficConfig(held_length=0.8, wanted_length=0.4)
    tube = Tube(HOME, 3, longest.held_length, longest.wanted_length)
    tube.adopt(np.column_stack((np.arange(0.0, 3.0, 0.05), np.zeros(60))))
    tube.stop = tube.span[1]
    held, wanted, _ = tube.publish(HOME, 0)
    assert np.allclose(held[-1], tube.stop_point)
    assert len(wanted) == WANTED_POINTS
    block, size = padded(np.ones((5, 2)), 3)
    assert (block.shape, size) == ((3, 2), 3)
    block, size = padded(np.ones((1, 2)), 3)
    assert size == 1
    assert block[1:].tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_the_robots_index_follows_it_but_not_across_a_loop():
    out_and_back = np.column_stack((np.r_[0:1:20j, 1:0:20j], np.zeros(40)))
    tube = Tube(HOME, 3, 0.35, 0.35)
    tube.adopt(out_and_back)
    tube.advance(Pose(0.2, 0.0, 0.0), 39)
    assert tube.near == 4


def test_lengths_and_corners_of_the_path_ahead():
    tube = Tube(HOME, 3, 0.35, 0.35)
    east = np.column_stack((np.arange(0.0, 0.5, 0.05), np.zeros(10)))
    north = np.column_stack((np.full(5, 0.45), np.arange(0.05, 0.3, 0.05)))
    tube.adopt(np.vstack((east, north)))
    assert tube.corners == [9]
    assert tube.next_corner() == 9
    tube.near = 9
    assert tube.next_corner() == len(tube.points) - 1
    tube = tube_along_x(1.0)
    tube.near = 4
    assert tube.length_ahead() == pytest.approx(0.75)


@pytest.mark.parametrize("count", [50, 64, 65, 150])
def test_requests_are_remembered_with_their_ticks_until_one_changes(count):
    tube = tube_along_x()
    for tick in range(count):
        tube.stop = min(tick // 10, 3)
        tube.publish(HOME, tick)
    assert tube.requests[-1].tolist() == [count - 1, 10]
    assert tube.requests[:, 0].tolist() == list(range(count - len(tube.requests), count))
    assert (np.diff(tube.requests[:, 1]) >= 0).all()
    assert len(tube.requests) == min(count, REMEMBERED)
    tube.forget_requests()
    assert len(tube.requests) == 0


def test_requests_are_published_with_zeros_behind_them():
    tube = Tube(HOME, 3, 0.35, 0.35)
    tube.adopt(np.column_stack((np.arange(0.0, 4.0, 0.05), np.zeros(80))))
    tube.stop = 30
    sizes = [len(points) for points in tube.publish(HOME, 0)]
    assert sizes == [24, 7, 25]
    tube.reset(HOME)
    held, wanted, intent = tube.publish(HOME, 1)
    assert (held.tolist(), len(wanted), len(intent)) == ([[0.0, 0.0]], 0, 1)
    assert not tube.published.any()
    tube = Tube(HOME, 3, 0.35, 0.35)
    for tick in range(40):
        tube.publish(HOME, tick)
    assert tube.requests[:, 0].tolist() == list(range(8, 40))
