"""Energy over simulated time: against hand-computed figures and a slow twin."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from swarm_common.model.battery import BatterySpec, SupplyStatus
from swarm_common.model.beacon import empty_beacons
from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist
from swarm_common.model.sites import Sites
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import Scene
from swarm_sim.world.batteries import Batteries
from swarm_sim.world.world import World, WorldConfig

WAFFLE = load_robot("turtlebot3_waffle")
BATTERY = BatterySpec(
    capacity=1.0, voltage=12.0, idle_power=5.0, drive_power=10.0, turn_power=2.0,
    charge_power=36.0,
)  # fmt: skip
FAR = Pose(50.0, 0.0, 0.0)
CHARGER = Pose(2.0, 0.0, 0.0)


def pass_time(
    batteries, ticks, places,
    twist = (0.0, 0.0, 0.0), start = 0,
):  # fmt: skip
    poses = np.array([(x, y, 0.0) for x, y in places])
    twists = np.tile(twist, (len(places), 1))
    for tick in range(start + 1, start + ticks + 1):
        batteries.update(tick, poses, twists)


def share(batteries, robot=0):
    return batteries.readings(0)[robot].share


def test_standing_and_driving_take_what_the_model_says():
    batteries = Batteries([BATTERY], [], 0)
    pass_time(batteries, 600, [(0.0, 0.0)])  # 60 s at 5 W: 300 J of 3600 J
    assert share(batteries) == pytest.approx(1.0 - 300.0 / 3600.0)
    pass_time(batteries, 600, [(0.0, 0.0)], (0.3, -0.5, 0.4))  # 5 + 10 * 0.5 + 2 * 0.5 = 11 W
    assert share(batteries) == pytest.approx(1.0 - 960.0 / 3600.0)
    verdict = batteries.verdict(0)
    assert verdict.energy_used == pytest.approx(960.0 / 3600.0)
    assert verdict.least == verdict.final == pytest.approx(1.0 - 960.0 / 3600.0)
    assert (verdict.charges, verdict.charging_time, verdict.empty_at) == (0, 0.0, None)


def test_charge_is_that_of_a_slow_twin():
    rng = np.random.default_rng(3)
    specs = [dataclasses.replace(BATTERY, capacity=c, initial=(0.5, 0.5)) for c in (0.3, 1.0, 2.0)]
    batteries = Batteries([specs[0], None, *specs[1:]], [CHARGER], 0)
    charge = [0.5 * spec.joules for spec in specs]
    for tick in range(1, 3000):
        poses = np.column_stack([rng.uniform(1.0, 3.0, (4, 2)), np.zeros(4)])
        twists = rng.uniform(0.0, 0.3, (4, 3)) * rng.integers(0, 2, (4, 1))
        batteries.update(tick, poses, twists)
        gaps = {
            row: math.dist(poses[robot, :2], (CHARGER.x, CHARGER.y))
            for row, robot in enumerate((0, 2, 3))
            if not twists[robot].any() and charge[row] > 0.0
        }
        on_it = min(gaps, key=gaps.__getitem__, default=None)
        for row, robot in enumerate((0, 2, 3)):
            vx, wz, vy = twists[robot].tolist()
            if charge[row] <= 0.0:
                continue
            if row == on_it and gaps[row] <= 0.6:
                charge[row] += 36.0 * CONTROL_PERIOD
            else:
                charge[row] -= (5.0 + 10.0 * math.hypot(vx, vy) + 2.0 * abs(wz)) * CONTROL_PERIOD
            charge[row] = min(max(charge[row], 0.0), specs[row].joules)
    found = [batteries.readings(0)[robot].share for robot in (0, 2, 3)]
    assert found == pytest.approx([c / s.joules for c, s in zip(charge, specs, strict=True)])


def test_a_station_charges_the_nearest_that_stands_until_it_is_full():
    half = dataclasses.replace(BATTERY, initial=(0.5, 0.5))
    batteries = Batteries([half, half], [CHARGER], 0)
    places = [(2.3, 0.0), (2.0, 0.5)]
    pass_time(batteries, 400, places)  # 40 s at 36 W: 1440 J
    assert share(batteries, 0) == pytest.approx(0.5 + 1440.0 / 3600.0)
    assert share(batteries, 1) == pytest.approx(0.5 - 200.0 / 3600.0)
    assert batteries.readings(0)[0].status is SupplyStatus.CHARGING
    assert batteries.readings(0)[1].status is SupplyStatus.DISCHARGING
    pass_time(batteries, 200, places)
    assert batteries.readings(0)[0] == dataclasses.replace(
        batteries.readings(0)[0], share=1.0, power=0.0, status=SupplyStatus.FULL
    )
    pass_time(batteries, 10, places, (0.1, 0.0, 0.0))
    assert batteries.readings(0)[0].status is SupplyStatus.DISCHARGING
    verdict = batteries.verdict(0)
    assert (verdict.charges, verdict.charging_time) == (1, pytest.approx(60.0))


def test_an_empty_battery_stops_and_silences_its_robot_for_good():
    tiny = dataclasses.replace(BATTERY, capacity=5.0 / 3600.0)  # 5 J: a second of standing
    batteries = Batteries([tiny, BATTERY], [CHARGER], 0)
    pass_time(batteries, 9, [(0.0, 0.0)] * 2)
    commands, beacons = [Twist(0.2), Twist(0.2)], list(empty_beacons(2))
    assert batteries.silenced(commands, beacons) == (commands, beacons)
    pass_time(batteries, 1, [(0.0, 0.0)] * 2, start=9)
    stopped, silent = batteries.silenced(commands, beacons)
    assert stopped == [Twist(), Twist(0.2)]
    assert silent[0] is None
    assert silent[1] is beacons[1]
    pass_time(batteries, 100, [(2.0, 0.0), (0.0, 0.0)], start=10)  # too late
    assert share(batteries) == 0.0
    verdict = batteries.verdict(0)
    assert verdict.empty_at == pytest.approx(1.0)


def test_charges_at_the_start_follow_seed_and_robot_alone():
    ranged = dataclasses.replace(BATTERY, initial=(0.4, 0.8))
    few, many = Batteries([ranged] * 3, [], 7), Batteries([None, *[ranged] * 30], [], 7)
    shares = [share(many, robot) for robot in range(1, 31)]
    assert [share(few, 1), share(few, 2)] == shares[:2]
    assert 0.4 <= min(shares) < 0.5
    assert 0.7 < max(shares) <= 0.8
    assert share(Batteries([ranged], [], 8)) != share(few)


def test_the_world_drives_the_batteries_of_robots_that_have_one():
    tiny = dataclasses.replace(BATTERY, capacity=10.0 / 3600.0)
    specs = [dataclasses.replace(WAFFLE, battery=tiny), WAFFLE]
    sites = Sites(stations={"c": FAR}, charging=("c",))
    scene = Scene("field", Path("."), (), sites=sites)
    config = WorldConfig(engine="planar", with_lidar=False)
    world = World(scene, specs, [Pose(0.0, 0.0, 0.0), Pose(0.0, 3.0, 0.0)], config)
    seen = world.observe()
    assert seen[0].battery.share == 1.0
    assert seen[1].battery is None
    world.step([Twist(0.2)] * 2, [None] * 2)
    assert world.observe()[0].battery is None  # once a second
    for _ in range(99):
        world.step([Twist(0.2)] * 2, [None] * 2)
    truth = [pose.x for pose, _ in world.ground_truth()]
    assert truth[0] < 0.4 < 1.9 < truth[1]
    robots = world.verdict.as_json()["robots"]
    assert robots["Srobot1"]["battery"]["empty_at"] == pytest.approx(1.5, abs=0.3)
    assert "battery" not in robots["Srobot2"]
