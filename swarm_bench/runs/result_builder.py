"""From a run of the bench that is over to its record."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from swarm_bench.runs.episode import Episode, RunOptions
from swarm_bench.runs.invariant import Invariant, least_slack
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.breaches import MissedGoal, UnfinishedGoal
from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.itinerary import StopOutcome
from swarm_nav.core.goals import Status
from swarm_run.record.compose import RobotFacts, compose_record
from swarm_run.record.figures import Steady, finite, percentiles, steady_of
from swarm_run.record.run_record import COUNTERS, Goals, RunRecord


def compose_result(
    options: RunOptions,
    episode: Episode,
    dead: Collection[int],
    invariant: Invariant,
    durations: Sequence[float],
    **others: Any,
) -> RunRecord:
    """Return the record of a run that is over.

    Args:
        episode: World, drivers and missions at the end.
        dead: Indices of the robots whose goals are not asked for.
        durations: [s] of wall time of brains' ticks, of all or of some.
        others: Further fields of the record.
    """
    verdict = episode.world.verdict.as_json()
    alive = {episode.world.names[i]: i for i in range(len(episode.drivers)) if i not in dead}
    outcomes = {name: episode.itineraries[index].outcomes for name, index in alive.items()}
    settled = [outcome for each in outcomes.values() for outcome in each]
    reached = [outcome for outcome in settled if outcome.reached]
    under_way = sum(not episode.itineraries[index].is_over for index in alive.values())
    total = sum(episode.itineraries[index].total for index in alive.values())
    is_endless = options.scenario.duration > 0.0
    times = [1e6 * each for each in durations]
    ticks = percentiles(times, median=50, p99=99) if times else {}
    return compose_record(
        {
            name: _facts(episode, index, outcomes[name], is_endless=is_endless)
            for name, index in alive.items()
        },
        Goals(
            len(settled) + under_way, len(reached), len(settled) - len(reached),
            total - len(settled),
        ),
        max((outcome.tick for outcome in settled), default=0) * CONTROL_PERIOD or None,
        verdict,
        missed=[
            MissedGoal(name, outcome.stop.name, outcome.tick * CONTROL_PERIOD, outcome.reason)
            for name, each in outcomes.items() for outcome in each if not outcome.reached
        ],
        unfinished=[] if is_endless or episode.orders else _unfinished(episode, alive.values()),
        is_endless=is_endless,
        **identity(options),
        min_held_gap=finite(invariant.gap),
        min_held_slack=finite(invariant.slack),
        least_held_slack=least_slack(episode.drivers),
        tick_us_median=ticks.get("median"),
        tick_us_p99=ticks.get("p99"),
        steady=_steady(episode, options.scenario, reached) if is_endless else None,
        no_guarantee="; ".join(episode.conditions.findings) if episode.conditions else "",
        orders=None if episode.orders is None else episode.orders.run.results(verdict["sim_time"]),
        centre=None if episode.centre is None else episode.centre.as_json(options.robots),
        **others,
    )  # fmt: skip


def _facts(
    episode: Episode, index: int, outcomes: Sequence[StopOutcome], *, is_endless: bool
) -> RobotFacts:
    itinerary, status = episode.itineraries[index], episode.drivers[index].status()
    ends = [(each.tick * CONTROL_PERIOD, each.duration) for each in outcomes if each.reached]
    asked = len(outcomes) if is_endless else itinerary.total
    return RobotFacts(
        reached=len(ends), failed=asked - len(ends), ends=ends,
        is_done=len(outcomes) == itinerary.total,
        hold_time=status.hold_time, wait_time=status.wait_time, counts=counts_of(status),
    )  # fmt: skip


def counts_of(status: Status) -> dict[str, int]:
    """Return what a robot has counted, by the names of `COUNTERS`."""
    names = {"recoveries": "number_of_recoveries"}
    return {name: getattr(status, names.get(name, name)) for name in COUNTERS}


def _steady(episode: Episode, scenario: Scenario, reached: Sequence[StopOutcome]) -> Steady:
    """Return what was finished after the warm-up: orders where there are any, else goals."""
    if episode.orders is not None:
        records = episode.orders.run.results(episode.world.sim_time)["orders"]
        done = [(each["done"], each["lead_time"]) for each in records if each["done"] is not None]
        return steady_of(done, scenario.warm_up, scenario.duration, "orders")
    finished = [(outcome.tick * CONTROL_PERIOD, outcome.duration) for outcome in reached]
    return steady_of(finished, scenario.warm_up, scenario.duration)


def identity(options: RunOptions) -> dict[str, Any]:
    """Return the fields that say which run it was."""
    return {
        "scenario": options.scenario.name,
        "method": options.method,
        "robots": options.robots,
        "seed": options.seed,
        "engine": options.engine,
        "conditions": conditions(options),
    }


def conditions(options: RunOptions) -> dict[str, Any]:
    """Return what a run depends on beside scenario, size, seed, method and engine.

    Returns:
        By name: what the scenario says of radio, LiDAR and noise, and the parameters that were
        given.
    """
    scenario = options.scenario
    return {
        "loss": scenario.loss,
        "delay": scenario.delay,
        "lidar": scenario.with_lidar,
        "noise": scenario.noise,
        **({"laps": scenario.laps} if scenario.laps != 1 else {}),
        **({"duration": scenario.duration} if scenario.duration else {}),
        **({"warm_up": scenario.warm_up} if scenario.duration else {}),
        **({"dispatch": scenario.dispatch} if scenario.dispatch else {}),
        **({"realistic": True} if options.realistic else {}),
        **{
            name if pattern == "/**" else f"{pattern} {name}": value
            for pattern, values in options.sections.items()
            for name, value in values.items()
        },
        **options.parameters,
        **{f"central.{name}": value for name, value in options.central.items()},
    }


def _unfinished(episode: Episode, alive: Collection[int]) -> list[UnfinishedGoal]:
    """Return the goals that robots were under way to."""
    found = []
    for index in alive:
        if not episode.itineraries[index].is_over:
            status, goal = episode.drivers[index].status(), episode.itineraries[index].next_stop
            state = f"{status.state} {status.detail}".strip()
            found.append(UnfinishedGoal(episode.world.names[index], goal, state))
    return found
