"""Going to charge and back, on ideal unicycles with ideal batteries."""

import dataclasses

import pytest

from swarm_common.model.battery import BatteryReading, BatterySpec, SupplyStatus
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.core.config import BatteryConfig
from swarm_nav.core.goals import GoalEnded, GoalKind, Outcome
from tests.fakes.navigation import Squad, config, room, waffle

HALL = room(12.0, 12.0)
CHARGERS = {"charger_1": Pose(2.0, 2.0, 0.0), "charger_2": Pose(10.0, 2.0, 0.0)}
START, GOAL, NEXT = Pose(4.0, 6.0, 0.0), Pose(8.0, 9.0, 0.0), Pose(3.0, 9.0, 0.0)
# 36 W into 0.2 Wh: a twentieth of the capacity in a second
BATTERY = BatterySpec(
    capacity=0.2, voltage=12.0, idle_power=1.0, drive_power=2.0, charge_power=36.0
)


class Powered(Squad):
    """A squad whose batteries are integrated and read once a second."""

    def __init__(
        self, poses, shares,
        chargers = ("charger_1",),
        current = None, battery = BATTERY, **changes,
    ):  # fmt: skip
        sites = Sites(
            stations={name: CHARGERS[name] for name in chargers}, charging=tuple(chargers)
        )
        spec = dataclasses.replace(waffle(), battery=battery)
        super().__init__(HALL, poses, config(**changes), sites, spec=spec)
        self.battery, self.shares = battery, [*shares]
        self.live = [CHARGERS[name] for name in (chargers if current is None else current)]
        self.charged: list[str] = []  # who was charged, in order

    def _step(self, deaf, dead):
        standing = [k for k, body in enumerate(self.bodies) if abs(body.twist.vx) < 0.02]
        nearest = {min(standing, key=lambda k: self.distance(k, c), default=-1) for c in self.live}
        for index, body in enumerate(self.bodies):
            speed = abs(body.twist.vx)
            on_it = index in nearest and any(body.pose.distance(c) < 0.6 for c in self.live)
            power = 36.0 if on_it else -1.0 - 2.0 * speed
            change = 0.1 * power / self.battery.joules
            self.shares[index] = min(1.0, max(0.0, self.shares[index] + change))
            if on_it and (not self.charged or self.charged[-1] != f"Srobot{index + 1}"):
                self.charged.append(f"Srobot{index + 1}")
            if self.tick % 10 == 0:
                status = SupplyStatus.CHARGING if on_it else SupplyStatus.DISCHARGING
                reading = BatteryReading(self.tick, self.shares[index], power, status)
                self.robots[index].on_battery(reading)
        super()._step(deaf, dead)

    def is_charging(self, index=0):
        return self.robots[index].status().state == "charging"


def reached(one, index=0):
    return [end.outcome for end in one.ended(index)] == [Outcome.SUCCEEDED]


def test_a_robot_whose_battery_is_low_charges_and_then_reaches_its_goal():
    one = Powered([START], [0.2])
    one.send(0, GOAL, goal_id=7)
    one.run_until(one.is_charging, 400)
    status = one.robots[0].status()
    assert (status.station, status.goal_map) == ("charger_1", GOAL)
    assert status.battery == pytest.approx(one.shares[0], abs=0.06)
    assert one.distance(0, CHARGERS["charger_1"]) <= 0.25
    assert one.robots[0].services.goal_id == 7
    feedback = one.robots[0].services.feedback()
    assert feedback.goal_id == 7
    assert feedback.distance_remaining > 5.0
    assert one.ended(0) == []
    one.run_until(lambda: not one.is_charging(), 400)
    assert 0.9 <= one.shares[0] < 0.96
    one.run_until(lambda: reached(one), 600)
    assert one.ended(0)[0].goal_id == 7
    assert one.distance(0, GOAL) <= 0.25
    assert one.charged == ["Srobot1"]
    assert one.robots[0].status().goals_reached == 1  # the charge is none


def test_a_robot_with_enough_goes_on_as_far_as_the_way_to_the_station_allows():
    one = Powered([START], [0.9])
    one.send(0, GOAL)
    one.run_until(lambda: reached(one), 400)
    assert one.charged == []
    # twice the way of 4.5 m takes 2 * 17 s * 1.5 W = 52 J of 720 J: about 0.07
    for share, goes in ((0.35, False), (0.30, True)):
        one = Powered([START], [share], battery__low=0.25)
        one.run(60)
        assert (one.robots[0].status().station == "charger_1") is goes, share


def test_robots_charge_without_a_goal_and_go_on_with_waypoints():
    one = Powered([START], [0.2])
    one.run_until(one.is_charging, 400)
    assert one.robots[0].services.feedback() is None
    one.run_until(lambda: not one.is_charging(), 400)
    one.run(5)
    status = one.robots[0].status()
    assert (status.state, status.station, status.goal_map) == ("idle", "", None)
    one = Powered([START], [0.5], battery__low=0.4)
    one.send(0, NEXT, GOAL, START, kind=GoalKind.WAYPOINTS)
    one.run_until(lambda: len(one.ended(0)) == 1, 2500)
    assert one.charged[:1] == ["Srobot1"]
    assert reached(one)
    assert one.ended(0)[0].missed_waypoints == ()


def test_goals_that_come_go_and_change_meanwhile_are_told_of_at_once():
    one = Powered([START], [0.2])
    one.send(0, GOAL, goal_id=1)
    one.run_until(one.is_charging, 400)
    one.send(0, NEXT, goal_id=2)
    one.run(2)
    assert one.ended(0) == [
        GoalEnded(1, Outcome.CANCELED, one.tick - 3, message="preempted by a new goal")
    ]
    assert one.robots[0].services.goal_id == 2
    assert one.is_charging()
    one.robots[0].services.cancel_goal()
    one.run(2)
    assert [end.goal_id for end in one.ended(0)] == [1, 2]
    assert one.robots[0].services.goal_id is None
    assert one.is_charging()
    one.send(0, NEXT, goal_id=3)
    one.run_until(lambda: len(one.ended(0)) == 3, 900)
    assert one.ended(0)[-1].outcome is Outcome.SUCCEEDED
    assert one.shares[0] > 0.6


def test_who_is_asked_for_a_behaviour_or_shut_down_does_not_charge():
    one = Powered([START], [0.2])
    one.run(60)
    assert one.robots[0].status().station == "charger_1"
    one.send(0, kind=GoalKind.SPIN, angle=1.0, goal_id=5)
    one.run_until(lambda: bool(one.ended(0)), 100)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    one.run_until(one.is_charging, 400)
    one = Powered([START], [0.2])
    one.run(60)
    one.robots[0].services.deactivate()
    one.run(300)
    assert not one.charged
    one.robots[0].services.activate()
    one.run_until(one.is_charging, 400)


def test_a_station_without_current_or_that_others_hold_is_passed_over():
    one = Powered([START], [0.4], ("charger_1", "charger_2"), current=("charger_2",))
    one.run(1)
    one.shares[0] = 0.3
    one.send(0, GOAL)
    one.run_until(lambda: reached(one), 2500)
    assert one.charged == ["Srobot1"]
    one = Powered(
        [Pose(2.5, 3.0, 0.0), Pose(5.0, 3.0, 0.0)], [0.1, 0.4], ("charger_1", "charger_2"),
        battery=dataclasses.replace(BATTERY, charge_power=1.0),
    )  # fmt: skip
    one.run_until(lambda: one.robots[0].status().state == "charging", 300)
    one.shares[1] = 0.25
    one.run(20)
    assert one.robots[1].status().station == "charger_2"  # farther, and free


def test_several_robots_share_one_station_one_after_the_other():
    poses = [Pose(4.0 + 1.5 * k, 6.0, 0.0) for k in range(4)]
    goals = [Pose(4.0 + 1.5 * k, 10.0, 0.0) for k in range(4)]
    one = Powered(poses, [0.28] * 4)
    for index, goal in enumerate(goals):
        one.send(index, goal)
    one.run_until(lambda: all(reached(one, k) for k in range(4)), 6000)
    assert {*one.charged} == {"Srobot1", "Srobot2", "Srobot3", "Srobot4"}
    assert min(one.shares) > 0.0


def test_a_robot_waits_for_the_station_as_long_as_others_take():
    slow = dataclasses.replace(BATTERY, capacity=2.5)  # 160 s of charging for each
    poses = [Pose(4.0 + 1.5 * k, 6.0, 0.0) for k in range(3)]
    one = Powered(poses, [0.24] * 3, battery=slow, traffic__patience=60.0)
    for index, pose in enumerate(poses):
        one.send(index, Pose(pose.x, 10.0, 0.0))
    stations: list[list[str]] = [[""], [""], [""]]
    while not all(reached(one, k) for k in range(3)):
        assert one.tick < 8000, [robot.status() for robot in one.robots]
        one.run(10)
        for known, robot in zip(stations, one.robots, strict=True):
            if (station := robot.status().station) != known[-1]:
                known.append(station)
    assert stations == [["", "charger_1", ""]] * 3  # nobody gave its turn up
    assert min(one.shares) > 0.1


def test_an_empty_robot_says_so_and_stands():
    one = Powered([START], [0.02], ())
    one.send(0, GOAL)
    one.run(400)
    status = one.robots[0].status()
    assert (status.state, status.detail) == ("waiting", "stands: its battery is empty")
    assert abs(one.bodies[0].twist.vx) < 1e-9


@pytest.mark.parametrize(("low", "enough"), [(0.9, 0.3), (0.5, 0.5), (-0.1, 0.5), (0.5, 1.1)])
def test_impossible_thresholds_are_refused(low, enough):
    with pytest.raises(ConfigError, match=r"battery\.(low|enough) is"):
        BatteryConfig(low=low, enough=enough)
