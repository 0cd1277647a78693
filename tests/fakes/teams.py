"""A team of one's own: sends each robot straight to its goal."""

from collections.abc import Mapping, Sequence
from typing import Any

from swarm_central.team import RobotReport, TeamOrder


class Straight:
    def __init__(self, *_: Any) -> None:
        self.reports: dict[int, RobotReport] = {}

    def observe(self, tick: int, states: Sequence[RobotReport]) -> None:
        self.reports = {report.robot_id: report for report in states if report.goal_id}

    def decide(self) -> Sequence[TeamOrder]:
        return [
            TeamOrder(
                robot_id=number,
                number=1,
                first=0,
                points_map=((report.pose_map.x, report.pose_map.y), report.goal_map),
            )
            for number, report in self.reports.items()
            if report.heard == 0
        ]

    def figures(self) -> Mapping[str, float]:
        return {"own": 1.0}
