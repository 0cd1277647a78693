"""ir-sim: differential drives with LiDARs; its group behaviour ORCA, which knows no walls."""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path
from typing import Any

import irsim

from benchmarks.peers.job import PERIOD, run

HORIZON = 3.0  # [s] of ORCA


class IrsimPeer:
    """An environment of ir-sim."""

    def __init__(self, job: dict[str, Any]) -> None:
        with tempfile.TemporaryDirectory(prefix="swarm-peer-") as folder:
            file = Path(folder) / "world.yaml"
            file.write_text(json.dumps(_world(job)), encoding="utf-8")  # JSON is YAML
            self._environment = irsim.make(
                str(file), display=False, disable_all_plot=True, log_level="ERROR"
            )

    def positions(self) -> list[list[float]]:
        """Return where the robots are."""
        return [robot.state[:2, 0].tolist() for robot in self._environment.robot_list]

    def set_goal(self, index: int, x: float, y: float) -> None:
        """Send a robot to a place."""
        self._environment.robot_list[index].set_goal([x, y, 0.0])

    def step(self) -> None:
        """Advance by `PERIOD`."""
        self._environment.step()


def _world(job: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a world file."""
    points = [point for outline in job["walls"] for point in outline]
    low = [min(point[axis] for point in points) for axis in (0, 1)]
    high = [max(point[axis] for point in points) for axis in (0, 1)]
    count = len(job["starts"])
    lidar = {
        "name": "lidar2d", "range_min": 0.0, "range_max": job["range"],
        "angle_range": 2.0 * math.pi, "number": job["rays"],
    }  # fmt: skip
    robots = {
        "number": count,
        "distribution": {"name": "manual"},
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": job["radius"]},
        "state": job["starts"],
        "goal": [[*goals[0], 0.0] for goals in job["goals"]],
        "vel_min": [0.0, -job["turn"]],
        "vel_max": [job["speed"], job["turn"]],
        "goal_threshold": 0.2,
        "group_behavior": {
            "name": "orca", "neighborDist": 5.0, "maxNeighbors": 10, "timeHorizon": HORIZON,
            "timeHorizonObst": HORIZON, "safe_radius": 0.05, "maxSpeed": job["speed"],
        },
        "sensors": [lidar],
    }  # fmt: skip
    walls = [
        {"shape": {"name": "polygon", "vertices": outline}, "static": True}
        for outline in job["walls"]
    ]
    pillars = [
        {"shape": {"name": "circle", "radius": radius}, "state": [x, y, 0.0], "static": True}
        for x, y, radius in job["pillars"]
    ]
    return {
        "world": {
            "width": high[0] - low[0], "height": high[1] - low[1], "offset": low,
            "step_time": PERIOD, "sample_time": PERIOD, "collision_mode": "unobstructed",
        },
        "robot": [robots],
        "obstacle": [*walls, *pillars],
    }  # fmt: skip


if __name__ == "__main__":
    run(IrsimPeer)
