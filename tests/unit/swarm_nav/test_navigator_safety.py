"""What the brain does when data is missing, others die, or parameters and maps change."""

import dataclasses
import math

import numpy as np
import pytest

from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.core.goals import ErrorCode, GoalKind, Outcome
from tests.fakes.navigation import Squad, beacon, config, room, waffle

HALL = room(8.0, 8.0)
START = Pose(2.0, 2.0, 0.0)
EAST = Pose(6.0, 2.0, 0.0)


def under_way(*poses, ticks=50, **changes):
    one = Squad(HALL, [START, *poses], config(**changes))
    one.send(0, EAST)
    one.run(ticks)
    assert one.bodies[0].twist.vx > 0.2
    return one


def test_a_deaf_robot_stops_within_what_it_holds_and_goes_on_when_it_hears_again():
    one = under_way()
    before = one.bodies[0].pose
    held = int(one.beacons[0]["held_size"])
    one.run(20, deaf=[0])
    assert one.bodies[0].twist.vx == 0.0
    assert one.distance(0, before) < 0.05 * held
    assert int(one.beacons[0]["wanted_size"]) == 0
    one.run_until(lambda: bool(one.ended(0)), 400)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize(("speed", "brakes"), [(0.26, 1.0), (0.26, 0.3), (0.4, 0.8)])
def test_a_robot_keeps_the_space_that_it_needs_to_stop(speed, brakes):
    slow = dataclasses.replace(waffle(), acc_lim_x=brakes, max_vel_x=speed)
    one = Squad(HALL, [START], config(max_vel_x=speed, acc_lim_x=brakes), spec=slow)
    one.send(0, EAST)
    one.run_until(lambda: one.bodies[0].twist.vx > 0.9 * speed, 100)
    one.run(1, deaf=[0])
    record = one.beacons[0]
    end = record["held"][record["held_size"] - 1]
    one.run(20, deaf=[0])
    assert one.bodies[0].pose.x <= end[0] + 0.005


def test_a_robot_whose_lidar_falls_silent_stops():
    one = Squad(HALL, [START])
    free = np.full(360, np.inf, np.float32)
    one.scan = lambda index, pose: free if one.tick % 2 == 0 and one.tick < 60 else None
    one.send(0, EAST)
    one.run(60)
    assert one.bodies[0].twist.vx > 0.2
    one.run(16)
    assert one.bodies[0].twist.vx == 0.0
    stood = one.bodies[0].pose
    one.run(30)
    assert one.distance(0, stood) < 1e-6


def ranges_to(pose, x, y, radius):
    """Return the scan of a disc from a LiDAR at (-0.064, 0) of the base."""
    lidar = pose.compose(Pose(-0.064, 0.0, 0.0))
    angles = lidar.yaw + np.arange(360) * math.tau / 360
    along = (x - lidar.x) * np.cos(angles) + (y - lidar.y) * np.sin(angles)
    across = (x - lidar.x) ** 2 + (y - lidar.y) ** 2 - along**2
    hit = (along > 0) & (across < radius**2)
    ranges = np.full(360, np.inf, np.float32)
    ranges[hit] = along[hit] - np.sqrt(radius**2 - across[hit])
    return ranges


def test_a_robot_drives_around_a_box_that_only_its_lidar_knows():
    one = Squad(HALL, [START])
    box = (4.0, 2.0, 0.2)
    one.scan = lambda index, pose: ranges_to(pose, *box) if one.tick % 2 == 0 else None
    one.send(0, EAST)
    nearest = 9.0
    while not one.ended(0) and one.tick < 900:
        one.run(1)
        here = one.bodies[0].pose
        nearest = min(nearest, math.hypot(here.x - box[0], here.y - box[1]) - box[2])
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert nearest > 0.25


@pytest.mark.parametrize("y", [1.8, 2.0, 2.13, 2.5])
def test_a_dead_robot_on_the_way_is_driven_around(y):
    one = under_way(Pose(4.0, y, 0.0))
    nearest = 9.0
    while not one.ended(0) and one.tick < 900:
        one.run(1, dead=[1])
        nearest = min(nearest, one.bodies[0].pose.distance(one.bodies[1].pose))
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert nearest > 0.5


@pytest.mark.parametrize("y", [1.8, 2.0, 2.13])
def test_an_inactive_robot_on_the_way_is_driven_around(y):
    one = Squad(HALL, [START, Pose(4.0, y, 0.0)])
    one.robots[1].services.deactivate()
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 500)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert one.distance(1, Pose(4.0, y, 0.0)) < 0.01


def test_a_dead_robot_on_the_station_ends_the_goal_after_the_patience():
    sites = Sites(stations={"dock": EAST})
    one = Squad(HALL, [START, EAST], config(holding__station_patience=5.0), sites)
    one.run(30)
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 900, dead=[1])
    end = one.ended(0)[0]
    assert (end.outcome, end.error_code) == (Outcome.ABORTED, ErrorCode.GOAL_OCCUPIED)
    assert "Srobot2 has not been heard for" in end.message
    assert one.distance(0, EAST) > 0.5


def test_a_goal_counts_within_its_tolerance_where_a_dead_robot_bars_the_last_centimetres():
    one = Squad(HALL, [START, Pose(6.78, 2.0, 0.0)])
    one.run(30)
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 400, dead=[1])
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert one.distance(0, EAST) <= 0.25


def test_an_idle_robot_on_the_goal_makes_room():
    one = Squad(HALL, [START, EAST])
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 600)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert one.bodies[0].pose.distance(one.bodies[1].pose) > 0.5
    assert one.robots[1].status().pushes >= 1
    one.run(40)
    assert one.robots[1].status().state == "idle"


def served_at_east(*, ticks):
    """Return two robots; the second is at EAST, and its next goal is due in some ticks."""
    one = Squad(HALL, [START, Pose(5.0, 2.0, 0.0)])
    one.send(1, EAST)
    one.run_until(lambda: bool(one.ended(1)), 200)
    one.send(1, Pose(6.0, 6.0, 0.0), goal_id=2, start_tick=one.tick + ticks)
    return one


def test_a_robot_that_is_served_stays_where_it_is_until_it_has_been_served():
    """Whoever came next pushed it off its station, by up to 1.8 m, while it was loaded there."""
    one = served_at_east(ticks=300)
    place = one.bodies[1].pose
    one.send(0, EAST)
    one.run(290)
    assert one.distance(1, place) < 0.1  # it stopped
    assert one.robots[1].status().state == "pausing"
    assert not one.ended(0)
    one.run_until(lambda: bool(one.ended(0)) and len(one.ended(1)) == 2, 600)
    assert {end.outcome for k in (0, 1) for end in one.ended(k)} == {Outcome.SUCCEEDED}


def test_a_robot_whose_next_goal_is_canceled_while_it_is_served_makes_way():
    one = served_at_east(ticks=3000)
    one.send(0, EAST)
    one.run(200)
    assert not one.ended(0)
    one.robots[1].services.cancel_goal()
    one.run_until(lambda: bool(one.ended(0)), 600)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED


def test_a_robot_that_was_sent_away_since_does_not_count_as_served():
    one = Squad(HALL, [START, Pose(5.0, 2.0, 0.0)])
    one.send(1, EAST)
    one.run_until(lambda: bool(one.ended(1)), 200)
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 600)  # pushed it off
    one.send(1, EAST, goal_id=2, start_tick=one.tick + 500)
    one.run(2)
    assert one.robots[1].status().state != "pausing"


def test_a_robot_that_waits_on_orders_resumes_waiting_after_making_way():
    one = Squad(HALL, [START, Pose(4.0, 2.0, 0.0)])
    one.run(20)
    one.send(1, kind=GoalKind.SPIN, angle=200.0, goal_id=9)
    one.send(0, EAST)
    one.run_until(lambda: bool(one.ended(0)), 800)
    one.run(40)
    assert one.robots[1].services.goal_id == 9
    assert one.robots[1].status().state == "pausing"
    assert abs(one.bodies[1].twist.wz) > 0.5


def test_two_robots_pass_each_other_in_a_corridor():
    corridor = room(10.0, 1.8)
    ends = [Pose(0.8, 0.9, 0.0), Pose(9.2, 0.9, math.pi)]
    pair = Squad(corridor, ends)
    pair.send(0, ends[1])
    pair.send(1, ends[0])
    nearest = 9.0
    while not (pair.ended(0) and pair.ended(1)) and pair.tick < 1200:
        pair.run(1)
        nearest = min(nearest, pair.bodies[0].pose.distance(pair.bodies[1].pose))
    assert [e.outcome for k in (0, 1) for e in pair.ended(k)] == [Outcome.SUCCEEDED] * 2
    assert nearest > 0.5
    assert pair.tick < 600


def test_an_inactive_navigator_holds_its_place_and_takes_up_work_again():
    one = under_way()
    one.robots[0].services.deactivate()
    one.run(20)
    assert one.ended(0)[0].outcome is Outcome.CANCELED
    assert one.robots[0].status().state == "inactive"
    assert one.bodies[0].twist.vx == 0.0
    one.send(0, EAST)
    stood = one.bodies[0].pose
    one.robots[0].services.activate()
    one.run(16)
    assert one.distance(0, stood) < 1e-6  # listens first
    one.run_until(lambda: len(one.ended(0)) == 2, 400)
    assert one.ended(0)[1].outcome is Outcome.SUCCEEDED


def test_new_limits_and_maps_take_effect_at_once():
    one = under_way()
    one.robots[0].services.reconfigure(config(max_vel_x=0.1))
    one.run(5)
    assert one.bodies[0].twist.vx == pytest.approx(0.1, abs=0.01)
    assert one.robots[0].reservation_config.controller.max_vel_x == 0.1
    one = Squad(HALL, [START])
    one.robots[0].services.load_map(room(8.0, 8.0, (4.0, 0.0, 4.15, 5.0)))
    path = one.robots[0].services.make_plan(None, [EAST])
    assert path[:, 1].max() > 5.0


def test_cells_of_another_size_have_regions_of_their_own():
    """A region of the old cells ended a navigator that was to make way for others in it."""
    hall = room(28.0, 14.0, (2.5, 1.4, 25.5, 1.8), (0.0, 4.2, 28.0, 4.6))
    sites = Sites(stations={"aisle": Pose(14.0, 0.7, 0.0)})
    robot = Squad(hall, [Pose(1.0, 3.0, 0.0)], sites=sites).robots[0]
    before = robot._gate.region
    robot.services.reconfigure(config(planner__resolution=0.2))
    assert robot._gate.region.shape == robot._s.planner.lattice.base.shape != before.shape


def test_new_parameters_reach_every_layer():
    one = under_way()
    one.robots[0].services.reconfigure(
        config(costmap__obstacle_max_range=1.0, traffic__confirmations=6, traffic__held_length=0.2)
    )
    s = one.robots[0]._s
    free = np.full(360, np.inf, np.float32)
    free[0] = 1.5
    one.scan = lambda index, pose: free if one.tick % 2 == 0 else None
    one.run(10)
    assert len(s.obstacles.points) == 0
    assert s.tube.stop - s.tube.near <= 4
    assert s.tube._confirmations == 6


def test_a_pose_from_the_operator_replaces_the_estimate_and_the_claims():
    one = under_way()
    robot = one.robots[0]
    robot.services.on_initial_pose(Pose(5.0, 6.0, 1.0))
    assert robot.pose_map.distance(Pose(5.0, 6.0, 1.0)) < 1e-9
    way = robot.services.plan_map()
    assert np.hypot(*(way - (5.0, 6.0)).T).max() < 0.11  # no more than it takes to stop


def test_a_beacon_is_sent_in_every_tick_after_deafness_too():
    one = under_way()
    for deaf in ([], [0], []):
        one.run(1, deaf=deaf)
        record = one.beacons[0]
        assert int(record["tick"]) == one.tick - 1
        here = one.robots[0].pose_map
        assert np.allclose(record["pose"][:2], (here.x, here.y), atol=1e-6)
    one = under_way()
    one.run(40, deaf=[0])
    stood = one.bodies[0].pose
    one.run(15)
    assert one.distance(0, stood) < 0.01
    one.run(30)
    assert one.distance(0, stood) > 0.1


def test_a_parked_robot_keeps_its_way_to_a_refuge_from_the_first_tick():
    station = Pose(4.0, 4.0, 0.0)
    one = Squad(HALL, [Pose(4.0, 0.8, 0.0)], config(holding__mode="park"))
    others = (3, 4, 5)
    one.extra_beacons = [
        beacon(k, k - 0.5, 7.0, station=(station.x, station.y), station_tick=1) for k in others
    ]
    one.run(10)  # the others asked before
    one.send(0, station)
    one.run_until(lambda: one.robots[0].status().state == "holding", 300)
    one.run(150)
    here = one.bodies[0].pose
    way = [(here.x - 0.75 + 0.1 * k, here.y) for k in range(31)]
    pusher = beacon(2, *way[0], intent=way, wanted=way[:4], blocked_by=1, blocked_ticks=20)
    pusher["priority"] = (2**18 - 1, 2**32 - 1)
    one.extra_beacons.append(pusher)
    one.run(3)
    assert one.robots[0].status().state == "yielding"
    assert len(one.robots[0].services.plan_map()) > 3


def test_a_robot_that_had_no_data_holds_its_place_only_and_listens_first():
    one = under_way()
    one.run(40, dead=[0])  # as on a host without link
    stood = one.bodies[0].pose
    for _ in range(15):
        one.run(1)
        record = one.beacons[0]
        assert int(record["held_size"]) == 1
        assert one.distance(0, stood) < 0.01
    one.run_until(lambda: bool(one.ended(0)), 400)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize("ticks", [20, 90, 110, 150, 200])
def test_who_comes_back_meets_nobody_who_went_on_in_the_meantime(ticks):
    one = under_way(Pose(3.6, 4.5, -math.pi / 2))
    one.send(1, Pose(3.6, 0.8, -math.pi / 2))
    nearest = 9.0
    for tick in range(700):
        one.run(1, dead=[0] if tick < ticks else [])
        nearest = min(nearest, one.bodies[0].pose.distance(one.bodies[1].pose))
    assert nearest > 2 * 0.238
    assert [one.ended(i)[0].outcome for i in (0, 1)] == [Outcome.SUCCEEDED] * 2
