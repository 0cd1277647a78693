"""What the robots did and when, for the report: a line whenever the state of one changes."""

from __future__ import annotations

from swarm_interfaces.msg import RobotStatus

from swarm_common.journal import Journal

FILE = "robots.jsonl"


class Diary:
    """Writes changes of state with their stamps, goals sent and goals settled."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._latest: dict[str, tuple[object, ...]] = {}

    def note(self, robot: str, status: RobotStatus) -> None:
        """Take in a status; one that says nothing new is not written."""
        news = (
            status.state,
            status.station,
            int(status.queue_place),
            int(status.goals_reached),
            int(status.goals_failed),
        )
        if self._latest.get(robot) == news:
            return
        self._latest[robot] = news
        state, station, place, reached, failed = news
        self._journal.write(
            t=round(status.stamp.sec + 1e-9 * status.stamp.nanosec, 3),
            robot=robot,
            state=state,
            station=station,
            place=place,
            reached=reached,
            failed=failed,
        )

    def goal(self, robot: str, goal: str, outcome: str, t: float, duration: float = 0.0) -> None:
        """Note that a goal was `sent`, `reached` or `failed` at a time [s]."""
        self._journal.write(t=t, robot=robot, goal=goal, outcome=outcome, duration=duration)
