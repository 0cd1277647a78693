"""Runs in random halls: which runs a seed means, and how one is built and run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from swarm_bench.halls.hall import Hall
from swarm_bench.halls.hall_maker import MISSIONS, HallRequest, make_hall
from swarm_bench.runs.episode import (
    Episode,
    RunOptions,
    bodies_of,
    episode_of,
    nav_config,
    setup_of,
    specs_of,
)
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_mission.leg import Stop
from swarm_run.record.run_record import RunRecord

SIZES = (5, 12, 20, 35, 50)
NONE, DEAD, RADIO, PEOPLE, MIXED = TROUBLES = ("none", "dead", "radio", "people", "mixed")
DRAWN = "drawn"
FLEET = ("turtlebot3_burger", "turtlebot3_waffle")
RADIOS = (0.1, 0.2, 0.3)  # share of losses, and delay [s]
TIME_LIMIT = 3600.0  # [s]


def hall_runs(
    seeds: Sequence[int], sizes: Sequence[int], mission: str, trouble: str, **common: Any
) -> list[RunOptions]:
    """Return the run of each seed and size.

    Args:
        sizes: Swarm sizes; empty: one of `SIZES` by the seed.
        mission: One of `MISSIONS`, or `DRAWN`.
        trouble: One of `TROUBLES`, or `DRAWN`: by the seed, none in every second one.

    Raises:
        ConfigError: If mission or trouble is none of these.
    """
    if mission not in (*MISSIONS, DRAWN):
        raise UnknownNameError("mission", mission, (*MISSIONS, DRAWN))
    if trouble not in (*TROUBLES, DRAWN):
        raise UnknownNameError("trouble", trouble, (*TROUBLES, DRAWN))
    if any(size < 2 for size in sizes):
        raise ConfigError("--robots: a hall is for 2 robots or more")
    return [
        RunOptions(
            scenario=_scenario(seed, size, mission, trouble), robots=size, seed=seed, **common
        )
        for seed in seeds
        for size in (sizes or (SIZES[seed % len(SIZES)],))
    ]


def _scenario(seed: int, size: int, mission: str, trouble: str) -> Scenario:
    """Return what the row of a run is called, and its radio, fleet and LiDARs."""
    number = seed // len(SIZES)  # every size meets every trouble and mission
    if trouble == DRAWN:
        trouble = NONE if number % 2 == 0 else TROUBLES[1 + number // 2 % 4]
    if mission == DRAWN:
        mission = MISSIONS[(number // 2 + seed) % len(MISSIONS)]
    level = RADIOS[seed % len(RADIOS)] if trouble == RADIO else 0.0
    name = "hall" if trouble == NONE else f"hall, {trouble}"
    return Scenario(
        name=name,
        description=mission,
        robots=(size,),
        fleet=FLEET if trouble == MIXED else (),
        loss=level,
        delay=level,
        with_lidar=trouble in (DEAD, PEOPLE),
        time_limit={size: TIME_LIMIT},
        world="hall",
        mission=mission,
    )


def run_hall(options: RunOptions) -> RunRecord:
    """Run one of `hall_runs`, and return its result.

    Raises:
        ConfigError: If no hall for so many robots comes up.
    """
    return Harness(options, episode=build_hall(options)).run()


def load_hall_inputs(options: RunOptions) -> str:
    """Check the parameters of one of `hall_runs`, and read its robots; the hall is drawn.

    Returns:
        Empty: in drawn halls nobody gives orders.
    """
    for spec in specs_of(options):
        nav_config(options, spec)
    bodies_of(options)
    return ""


def hall_of(options: RunOptions) -> tuple[Hall, Grid]:
    """Return the hall of a run and its map.

    Args:
        options: One of `hall_runs`.

    Raises:
        ConfigError: If no hall for so many robots comes up.
    """
    scenario, count = options.scenario, options.robots
    widest = max(specs_of(options), key=lambda spec: spec.circumscribed_radius)
    margin = nav_config(options, widest).traffic.safety_margin
    trouble = scenario.name.partition(", ")[2]
    radius = widest.circumscribed_radius
    wish = HallRequest(
        robots=count,
        radius=radius,
        reach=2.0 * (radius + margin),
        mission=scenario.mission,
        dead=max(1, count // 10) if trouble == DEAD else 0,
        people=2 if trouble == PEOPLE else 0,
    )
    return make_hall(wish, options.seed)


def build_hall(options: RunOptions) -> Episode:
    """Return the episode of one of `hall_runs`.

    Raises:
        ConfigError: If no hall for so many robots comes up.
    """
    hall, grid = hall_of(options)
    scene = dataclasses.replace(hall.scene(), walkers=hall.walkers)
    silent = range(options.robots - hall.dead, options.robots)
    setup = setup_of(options, scene, hall.homes, grid, silent)
    names = {(pose.x, pose.y): name for name, pose in scene.sites.stations.items()}
    return episode_of(options, setup, [_stops(goals, names) for goals in hall.goals], 1)


def _stops(goals: Sequence[Pose], names: dict[tuple[float, float], str]) -> list[Stop]:
    return [
        Stop(names.get((pose.x, pose.y), f"place_{number}"), pose, 2)
        for number, pose in enumerate(goals, 1)
    ]
