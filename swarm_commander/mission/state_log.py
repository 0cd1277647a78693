"""States of the robots over time, for the report: a line whenever the state of one changes."""

from __future__ import annotations

from rclpy.serialization import serialize_message
from swarm_interfaces.msg import RobotStatus

from swarm_common.files.journal import Journal
from swarm_common.middleware.topic_table import robot_topic
from swarm_common.model.breaches import MissedGoal
from swarm_common.model.records import CONTROL_PERIOD
from swarm_common.model.run_words import stopped_by
from swarm_common.process.messages import GoalMissed, GoalReached, GoalSent
from swarm_common.process.pipes import EventWriter
from swarm_mission.itinerary import NextGoal, StopOutcome
from swarm_recording.run_trace import RunTrace
from swarm_run.robots.driver import sim_seconds

FILE = "robots.jsonl"
KEPT_PERIOD = 2.0  # [s] between two statuses for replays that say the same
WAIT_STEP = 1.0  # [s] of waiting between two lines about it


class StateLog:
    """Writes changes of state with their stamps, goals sent and goals settled."""

    def __init__(self, journal: Journal, trace: RunTrace | None = None) -> None:
        """Begin to write.

        Args:
            journal: Open file, a JSON object per line.
            trace: Keeps statuses for replays; None if nobody wants that.
        """
        self._journal = journal
        self._trace = trace
        self._kept: dict[str, tuple[float, object]] = {}  # when, and what it said
        self._latest: dict[str, tuple[object, ...]] = {}
        self._waited: dict[str, float] = {}

    def note(self, robot: str, status: RobotStatus) -> None:
        """Write a change of the status, or that the robot had to wait; otherwise write nothing.

        Args:
            robot: Name of the robot, like `Srobot3`.
            status: Status as received; the stamp in it is the time that is written.
        """
        at = round(status.stamp.sec + 1e-9 * status.stamp.nanosec, 3)
        self._keep(robot, status, at)
        waited = float(status.wait_time)
        if waited < self._waited.setdefault(robot, 0.0):  # its navigator was started again
            self._waited[robot] = 0.0
        if waited >= self._waited[robot] + WAIT_STEP:
            self._journal.write(t=at, robot=robot, waited=round(waited - self._waited[robot], 3))
            self._waited[robot] = waited
        news = (
            status.state,
            status.station,
            int(status.queue_place),
            int(status.goals_reached),
            int(status.goals_failed),
            stopped_by(status.state, status.detail),
        )
        if self._latest.get(robot) == news:
            return
        self._latest[robot] = news
        state, station, place, reached, failed, blocker = news
        self._journal.write(
            t=at,
            robot=robot,
            state=state,
            station=station,
            place=place,
            reached=reached,
            failed=failed,
            blocker=blocker,
        )

    def _keep(self, robot: str, status: RobotStatus, at: float) -> None:
        """Keep a status that says something new, or is the first after a while."""
        if self._trace is None:
            return
        said = status.state, status.detail, status.station, status.queue_place, status.goals_reached
        before = self._kept.get(robot)
        if before is None or before[1] != said or at >= before[0] + KEPT_PERIOD:
            self._kept[robot] = at, said
            tick = round(at / CONTROL_PERIOD)
            self._trace.write(robot_topic(robot, "status"), tick, serialize_message(status))

    def close(self) -> None:
        """Complete what is kept for replays."""
        if self._trace is not None:
            self._trace.close()

    def goal(self, robot: str, goal: str, outcome: str, t: float, duration: float = 0.0) -> None:
        """Note what became of a goal.

        Args:
            outcome: `sent`, `reached` or `failed`.
            t: Simulated time [s].
            duration: [s] that the stop took, with all tries; 0 when it is sent.
        """
        self._journal.write(t=t, robot=robot, goal=goal, outcome=outcome, duration=duration)


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
