"""A robot that died on a station or on its way to one: whoever waits is told, or gets in."""

import math

import numpy as np
import pytest

from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_common.model.sites import Sites
from swarm_nav.core.goals import ErrorCode, Outcome
from tests.fakes.navigation import Squad, config, room, waffle

HALL = room(7.0, 7.0)
DOCK = Pose(3.5, 3.5, 0.0)
SITES = Sites(stations={"dock": DOCK})
STARTS = [Pose(1.0, 1.0, 0.0), Pose(6.0, 1.0, 0.0), Pose(1.0, 6.0, 0.0), Pose(6.0, 6.0, 0.0)]
PATIENCE = 20.0  # [s]
DRIVE = 40.0  # [s] enough to come near from any start
VICTIM = 4  # index


def squad(victim):
    """Robots without LiDARs: theirs would see that there is nobody on the station."""
    parameters = config(
        holding__station_patience=PATIENCE, holding__mode="park", costmap__scan_timeout=0.0
    )
    swarm = Squad(HALL, [*STARTS, victim], parameters, SITES)
    swarm.scan = lambda index, pose: None
    swarm.run(30)
    return swarm


def queue(swarm, seconds):
    for index in range(VICTIM):
        swarm.send(index, DOCK, goal_id=index)
    ticks = round(seconds / CONTROL_PERIOD)
    swarm.run_until(lambda: all(swarm.ended(k) for k in range(VICTIM)), ticks, dead=[VICTIM])


def test_all_who_wait_for_a_station_under_a_dead_robot_end_with_goal_occupied():
    swarm = squad(DOCK)
    begun = swarm.tick
    queue(swarm, 5 * (PATIENCE + DRIVE))
    ends = [swarm.ended(k)[0] for k in range(VICTIM)]
    assert {(e.outcome, e.error_code) for e in ends} == {(Outcome.ABORTED, ErrorCode.GOAL_OCCUPIED)}
    assert all(f"Srobot{VICTIM + 1} has not been heard for" in e.message for e in ends)
    waits = [(e.tick - begun) * CONTROL_PERIOD for e in ends]
    assert min(waits) >= PATIENCE
    assert max(waits) <= PATIENCE + DRIVE


def test_while_they_wait_their_status_says_for_what():
    swarm = squad(DOCK)
    for index in range(VICTIM):
        swarm.send(index, DOCK)
    swarm.run(round(0.6 * PATIENCE / CONTROL_PERIOD), dead=[VICTIM])
    near = [r.status() for r in swarm.robots[:VICTIM] if r.pose_map.distance(DOCK) < 3.0]
    assert near
    assert all(s.station == "dock" for s in near)


def test_the_lease_of_a_robot_that_died_on_its_way_is_free_again():
    swarm = squad(Pose(3.5, 0.6, math.pi / 2))
    swarm.send(VICTIM, DOCK)
    swarm.run_until(lambda: swarm.distance(VICTIM, DOCK) < 1.8, 400)
    queue(swarm, 300.0)
    assert [swarm.ended(k)[0].outcome for k in range(VICTIM)] == [Outcome.SUCCEEDED] * VICTIM


@pytest.mark.parametrize("state", ["inactive", "alive"])
def test_a_robot_that_answers_but_stays_is_not_waited_for_in_silence(state):
    parameters = config(
        holding__station_patience=PATIENCE, holding__mode="park", traffic__patience=60.0
    )
    swarm = Squad(HALL, [STARTS[0], DOCK], parameters, SITES)
    if state == "inactive":
        swarm.robots[1].services.deactivate()
    swarm.run(30)
    swarm.send(0, DOCK)
    swarm.run_until(lambda: bool(swarm.ended(0)), 2000)
    end = swarm.ended(0)[0]
    if state == "alive":
        assert end.outcome is Outcome.SUCCEEDED  # it made room
    else:
        assert end.error_code in (ErrorCode.GOAL_OCCUPIED, ErrorCode.FAILED_TO_MAKE_PROGRESS)


def test_a_dead_robot_that_was_never_heard_bars_a_station_as_well():
    """Robots that came later see only its LiDAR; they drove around it for ever, in turn."""
    parameters = config(holding__station_patience=PATIENCE, holding__mode="park")
    swarm = Squad(HALL, STARTS[:2], parameters, SITES)
    swarm.scan = lambda index, pose: seen(pose, (DOCK.x + 0.1, DOCK.y))
    swarm.run(30)
    for index in range(2):
        swarm.send(index, DOCK)
    swarm.run_until(
        lambda: all(swarm.ended(k) for k in range(2)),
        round(4 * (PATIENCE + DRIVE) / CONTROL_PERIOD),
    )
    ends = [swarm.ended(k)[0] for k in range(2)]
    assert {e.error_code for e in ends} == {ErrorCode.GOAL_OCCUPIED}
    assert all("does not move" in e.message for e in ends)


def seen(pose, place, radius=0.05):
    """Return a scan that sees a round thing and nothing else."""
    offset = waffle().lidar
    there = pose.compose(Pose(offset.x, offset.y, offset.yaw)).inverse().compose(Pose(*place, 0.0))
    distance, bearing = math.hypot(there.x, there.y), math.atan2(there.y, there.x)
    angles = np.arange(360) * math.tau / 360.0
    off = np.abs(np.angle(np.exp(1j * (angles - bearing))))
    is_hit = distance * np.sin(np.minimum(off, math.pi / 2)) < radius
    return np.where(is_hit, distance - radius, np.inf).astype(np.float32)
