"""The bench as a backend: world and navigators in this process, tick by tick, without ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_common.model.breaches import Collision
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec, Scan
from swarm_nav.core.goals import Goal as NavGoal
from swarm_nav.core.goals import GoalEnded, GoalKind, Output, Status
from swarm_nav.interfaces import Served
from swarm_run.loop import InjectedFaults
from swarm_workbench.goal import Goal
from swarm_workbench.history import RunTables
from swarm_workbench.report import Report, RobotFigures
from swarm_workbench.trajectories import Trajectories

STATUS_TICKS = 5  # 2 Hz, as navigators on the graph


class _Stepped(Harness):
    """A harness that has decided its present tick, and goes on although missions are over."""

    def __init__(self, options: RunOptions, faults: InjectedFaults | None) -> None:
        super().__init__(options, faults=faults)
        self.scans: list[Scan | None] = [None] * len(self.drivers)
        self.goals: dict[tuple[int, int], Goal] = {}  # by robot and id
        self.history = RunTables(self.world.names)
        self.think()

    def advance(self) -> bool:
        """Advance the world by a step, then decide."""
        self.act()
        self.think()
        return True

    def think(self) -> None:
        """Decide, and keep what is new."""
        super().think()
        tick = self.world.tick
        for index, (seen, output) in enumerate(zip(self.observed, self.outputs, strict=True)):
            self.scans[index] = seen.scan or self.scans[index]
            if output is not None and (output.events or tick % STATUS_TICKS == 0):
                status = self.drivers[index].status()
                self.history.note(self.world.names[index], status, tick * CONTROL_PERIOD)

    def die(self, robot: int) -> None:
        """Let a robot do and say nothing from the next tick on; its goals fail."""
        self.dead.add(robot)
        self.outputs[robot] = None
        for (owner, _), goal in self.goals.items():
            if owner == robot:
                goal.settle("aborted", "its navigator died", self.world.tick)

    def set_goal(self, robot: int, goal: Goal, order: Mapping[str, Any]) -> None:
        """Send a goal; it takes effect at the next tick."""
        if robot in self.dead:
            raise SwarmError(f"the navigator of {goal.robot} is dead; it takes no goals")
        self._goal_ids[robot] += 1
        self.goals[robot, self._goal_ids[robot]] = goal
        self.drivers[robot].set_goal(NavGoal(goal_id=self._goal_ids[robot], **order))

    def _follow_mission(self, index: int, tick: int, output: Output) -> None:
        """Settle goals of the program; the others are the mission's."""
        others = []
        for event in output.events:
            goal = None
            if isinstance(event, GoalEnded):
                goal = self.goals.pop((index, event.goal_id), None)
            if goal is None or not isinstance(event, GoalEnded):
                others.append(event)
                continue
            code = f"error {int(event.error_code)}: " if event.error_code else ""
            reason = "" if event.outcome.value == "succeeded" else f"{code}{event.message}"
            goal.settle(event.outcome.value, reason, event.tick)
        super()._follow_mission(index, tick, Output(output.twist, output.beacon, tuple(others)))


class BenchBackend:
    """World and navigators in this process."""

    def __init__(self, options: RunOptions, faults: InjectedFaults | None = None) -> None:
        """Build everything; the robots stand at tick 0.

        Raises:
            SwarmError: If a file or a value is unusable.
        """
        self._harness = _Stepped(options, faults)
        self._world, setup = self._harness.world, self._harness.episode.setup
        self.folder: Path | None = None
        self.grid, self.sites = setup.grid, setup.scene.sites
        self.names: Sequence[str] = self._world.names
        self.specs: Sequence[RobotSpec] = setup.specs
        self._is_closed = False
        self.url = ""
        self.domain: int | None = None
        self.history = self._harness.history
        self._true: list[FloatArray] = []
        self._estimated: list[FloatArray] = []
        self._record()

    @property
    def tick(self) -> int:
        """Control ticks since the start."""
        return self._world.tick

    def advance(self, ticks: int) -> None:
        """Let time pass."""
        for _ in range(ticks):
            self._harness.advance()
            self._record()

    def _record(self) -> None:
        self._true.append(self.true_poses())
        self._estimated.append(self.estimated_poses())

    def trajectories(self) -> Trajectories:
        """Return where every robot was at each tick so far."""
        times = np.arange(len(self._true), dtype=np.float64) * CONTROL_PERIOD
        true, estimated = np.stack(self._true), np.stack(self._estimated)
        return Trajectories(tuple(self.names), times, true, estimated)

    def true_poses(self) -> FloatArray:
        """Return x, y [m], yaw [rad] in map of each robot (n, 3)."""
        return self._world.poses.copy()

    def estimated_poses(self) -> FloatArray:
        """Return likewise what the robots believe."""
        poses: FloatArray = self._harness.beacons["pose"].astype(float)
        return poses

    def scan(self, robot: int) -> Scan | None:
        """Return a robot's latest scan."""
        return self._harness.scans[robot]

    def status(self, robot: int) -> Status:
        """Return a robot's status."""
        return self._harness.drivers[robot].status()

    def drive(self, robot: int, goal: Goal, pose: Pose) -> None:
        """Send a robot to a pose in map."""
        self._harness.set_goal(robot, goal, {"kind": GoalKind.NAVIGATE, "poses_map": (pose,)})

    def send(self, robot: int, goal: Goal, fields: Mapping[str, Any] | Any) -> None:
        """Send a goal of spin, wait, backup or drive_on_heading, by the fields of its message."""
        makers = {"spin": _spin, "wait": _wait, "backup": _drive, "drive_on_heading": _drive}
        if goal.action not in makers or not isinstance(fields, Mapping):
            raise ConfigError(
                f"the bench takes {', '.join(makers)} with the fields of Nav2's message as a"
                f" mapping, not {goal.action}; leave out bench=True for all of Nav2"
            )
        try:
            order = makers[goal.action](fields)
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"{goal.action} of {goal.robot}: {error!r} in {fields}") from None
        self._harness.set_goal(robot, goal, {"kind": GoalKind(goal.action), **order})

    def cancel(self, robot: int, goal: Goal) -> None:
        """Cancel a robot's goal."""
        driver = self._harness.drivers[robot]
        if not isinstance(driver, Served):
            raise SwarmError(f"a {type(driver).__name__} cannot cancel goals; send another one")
        driver.services.cancel_goal()

    def fail(self, robot: int) -> None:
        """Let a robot do and say nothing from now on."""
        self._harness.die(robot)

    def report(self) -> Report:
        """Return the figures so far."""
        verdict = self._world.verdict
        statuses = [driver.status() for driver in self._harness.drivers]
        return Report(
            sim_time=self._world.sim_time,
            robot_robot=verdict.robot_robot,
            robot_world=verdict.robot_world,
            near_misses=verdict.near_misses,
            min_clearance=verdict.min_clearance,
            robots=[
                figures_of(name, each) for name, each in zip(self.names, statuses, strict=True)
            ],
            full={},
        )

    def collisions(self) -> Sequence[Collision]:
        """Return the contact episodes."""
        return self._world.collisions

    def close(self) -> None:
        """Release what the physics engine holds."""
        if not self._is_closed:
            self._is_closed = True
            self._world.close()


def figures_of(name: str, status: Any) -> RobotFigures:
    """Return a robot's figures from its status, that of a navigator or the message."""
    return RobotFigures(
        robot=name,
        state=status.state,
        goals_reached=status.goals_reached,
        goals_failed=status.goals_failed,
        wait_time=status.wait_time,
        hold_time=status.hold_time,
        battery=status.battery,
    )


def _spin(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {"angle": _number(fields["target_yaw"]), "duration": _seconds(fields, "time_allowance")}


def _wait(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {"duration": _seconds(fields, "time")}


def _drive(fields: Mapping[str, Any]) -> dict[str, Any]:
    distance = _number(fields["target"]["x"])
    return {
        "distance": abs(distance),
        "is_reverse": distance < 0.0,
        "speed": abs(_number(fields["speed"])),
        "duration": _seconds(fields, "time_allowance"),
    }


def _seconds(fields: Mapping[str, Any], name: str) -> float:
    time = fields.get(name, {})
    return _number(time.get("sec", 0)) + 1e-9 * _number(time.get("nanosec", 0))


def _number(value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{value} is not finite")
    return number
