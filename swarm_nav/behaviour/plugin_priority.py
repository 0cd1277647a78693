"""A rule of who goes first that a user brings."""

from __future__ import annotations

import numbers

from swarm_common.model.records import Pose, RobotSpec
from swarm_common.process.plugins import PluginError
from swarm_nav.core.plugins import PRIORITY, Report
from swarm_nav.core.rank import TICK_BITS
from swarm_nav.interfaces import RankedGoal

MOST = (1 << TICK_BITS) - 1


class PluginPriority:
    """Asks the plug-in once for each target; a rank that changed on the way would cost space."""

    def __init__(self, name: str, spec: RobotSpec, report: Report) -> None:
        """Make the plug-in.

        Args:
            report: Receives faults; the robot ranks lowest meanwhile.

        Raises:
            ConfigError: If it is missing.
        """
        self._own = PRIORITY.guard(name, spec)
        self._report = report
        self._target: tuple[int, Pose | None] | None = None
        self._seniority = 0

    def last_goal_tick(
        self, robot_id: int, tick: int, last_goal_tick: int, pose_map: Pose, target_map: Pose | None
    ) -> int:
        """Return the tick that `base_priority` makes the plug-in's rank of.

        Args:
            robot_id: From 1.
            last_goal_tick: At which the last target was reached.
            target_map: None without a goal.
        """
        target = (last_goal_tick, target_map)
        if target != self._target:
            self._target = target
            self._seniority = self._ask(
                RankedGoal(robot_id, tick, last_goal_tick, pose_map, target_map)
            )
        return MOST - self._seniority

    def _ask(self, task: RankedGoal) -> int:
        try:
            value = self._own.call("seniority", task)
            if isinstance(value, numbers.Integral) and 0 <= int(value) <= MOST:
                return int(value)
            expected = "expected an int from 0 to 2**32 - 1"
            raise self._own.unusable(f"seniority returned {value!r}; {expected}")
        except PluginError as error:
            self._report(PRIORITY.codes[error.fault], str(error))
            return 0
