"""One call each: run a scenario, load a robot, start what `swarm-up` starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import Scenario, check_size, load_scenario
from swarm_commander.cli import session
from swarm_common.model.records import RobotSpec
from swarm_describe.robots import loading
from swarm_run.record.run_record import RunRecord as RunResult
from swarm_run.spec import RunSpec


def run_scenario(
    scenario: str | Scenario,
    *,
    robots: int | None = None,
    seed: int = 0,
    brain: str = "ours",
    parameters: Mapping[str, Any] | None = None,
    time_limit: float | None = None,
    lidar: bool | None = None,
) -> RunResult:
    """Run a scenario on the bench to its end.

    Args:
        scenario: Its name or file, or a `Scenario`.
        robots: Number of robots; None for the scenario's first.
        brain: What decides for each robot: ours, dwa, orca, `module:Class`, or a policy.onnx.
        parameters: Navigators' parameters by dotted name, in place of the defaults.
        time_limit: [s] of simulated time, in place of the scenario's limit or duration.
        lidar: Whether LiDARs run, in place of what the scenario says.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    chosen = scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))
    count = chosen.robots[0] if robots is None else robots
    if time_limit is not None:
        limits = {check_size(count, "robots"): time_limit}
        end = {"duration": time_limit} if chosen.duration else {"time_limit": limits}
        chosen = replace(chosen, **end)
    if lidar is not None:
        chosen = replace(chosen, with_lidar=lidar)
    return run(
        RunOptions(
            scenario=chosen, robots=count, seed=seed, method=brain, parameters=parameters or {}
        )
    )


def load_robot(model: str) -> RobotSpec:
    """Return what is known of a robot model.

    Args:
        model: Its name, or the path of a folder, URDF, xacro or robot.yaml.

    Raises:
        SwarmError: If there is no such model, or its files are unusable.
    """
    return loading.load_robot(model)


def start(options: RunSpec) -> int:
    """Run a swarm as `swarm-up` does, until it ends; return the exit code.

    Args:
        options: Description of the run; names as on the command line.

    Raises:
        SwarmError: If a file or a value is unusable, or the ROS domain is in use.
    """
    return session.start(options)
