"""Tells swarm-up, and the state log, what becomes of goals."""

from __future__ import annotations

from swarm_commander.mission.state_log import StateLog
from swarm_common.model.breaches import MissedGoal
from swarm_common.process.messages import GoalMissed, GoalReached, GoalSent
from swarm_common.process.pipes import EventWriter
from swarm_mission.itinerary import NextGoal, StopOutcome
from swarm_run.robots.driver import sim_seconds


class GoalNews:
    """The goals of the robots of one process."""

    def __init__(self, events: EventWriter, log: StateLog | None) -> None:
        """Begin without goals."""
        self._events = events
        self._log = log
        self._sent: dict[str, int] = {}  # number of the latest goal, by robot

    def sent(self, robot: str, order: NextGoal, tick: int) -> None:
        """Count a goal when it is sent first.

        Args:
            order: The goal; a second try of it is not counted again.
            tick: Now, by the robot's status.
        """
        if order.number <= self._sent.get(robot, 0):
            return
        self._sent[robot] = order.number
        self._events.write(GoalSent(robot, order.stop.name))
        if self._log is not None:
            self._log.goal(robot, order.stop.name, "sent", sim_seconds(max(order.start_tick, tick)))

    def settled(self, robot: str, outcome: StopOutcome) -> None:
        """Pass on a stop that was reached, or missed for good."""
        word, name = "reached" if outcome.reached else "failed", outcome.stop.name
        at, duration = sim_seconds(outcome.tick), round(outcome.duration, 3)
        if outcome.reached:
            self._events.write(GoalReached(robot, name, at, duration))
        else:
            self._events.write(GoalMissed(MissedGoal(robot, name, at, outcome.reason)))
        if self._log is not None:
            self._log.goal(robot, name, word, at, duration)
