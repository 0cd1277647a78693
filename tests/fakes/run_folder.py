"""The folder of a run that never took place."""

import json
import math
from pathlib import Path

import numpy as np

from swarm_common.files.journal import Journal
from swarm_common.files.map_io import save_map
from swarm_common.model.grid import Grid

SITES = "stations:\n  dock: [2.0, 2.0, 0.0]\n  shop: [4.0, 4.0, 0.0]\n"


def make_run(folder: Path, *, robots: int, seconds: int, crash: bool = False) -> Path:
    """Make a run in which robots circle for a time [s]; of none there is no report."""
    names = [f"Srobot{number}" for number in range(1, robots + 1)]
    for name in ("config", "trace"):
        (folder / name).mkdir(parents=True)
    sites = folder / "sites.yaml"
    sites.write_text(SITES)
    config = {"world": "hall", "sites": str(sites), "robots": [{"name": name} for name in names]}
    (folder / "config" / "world.json").write_text(json.dumps(config))
    if seconds:
        _write_trace(folder / "trace", names, seconds)
        report = _report(names, seconds, crash)
        (folder / "report.json").write_text(json.dumps(report))
    return folder


def _write_trace(trace: Path, names: list[str], seconds: int) -> None:
    cells = np.zeros((120, 120), np.int8)
    cells[0] = cells[-1] = 100
    save_map(Grid(cells, 0.05, 0.0, 0.0), trace / "map.yaml")
    world, robots = Journal(trace / "world.jsonl"), Journal(trace / "robots.jsonl")
    usage = Journal(trace / "usage.jsonl")
    world.write(robots=names, near_mm=500)
    for t in range(seconds + 1):
        angles = [0.1 * t + robot for robot in range(len(names))]
        world.write(
            t=t,
            x=[round(3000 + 1500 * math.cos(angle)) for angle in angles],
            y=[round(3000 + 1500 * math.sin(angle)) for angle in angles],
            yaw=[0 for _ in names],
            to_robot=[120 + t for _ in names],
            to_world=[500 for _ in names],
        )
        cpu = {"world": 0.1 * t, "navigators": 0.3 * t}
        usage.write(wall=t / 4, t=t, rtf=4.0, cpu=cpu, memory_mb={"world": 300, "navigators": 900})
    for name in names:
        for part, state in enumerate(("idle", "driving", "holding", "waiting", "pausing")):
            at = part * seconds / 5
            place = int(state == "holding")
            whom = names[-1] if state == "waiting" and name != names[-1] else ""
            robots.write(
                t=at, robot=name, state=state, station="dock", place=place, blocker=whom
            )  # fmt: skip
        robots.write(t=seconds / 2, robot=name, waited=1.0)
        for part, goal in enumerate(("dock", "shop"), 1):
            at = part * seconds / 2
            robots.write(t=at, robot=name, goal=goal, outcome="reached", duration=at)


def _report(names: list[str], seconds: int, crash: bool) -> dict[str, object]:
    goals = 2 * len(names)
    crashes = [{"robots": names[:2], "obstacle": "", "x": 1.0, "y": 2.0, "sim_time": 3.0}]
    missed = [{"robot": names[0], "goal": "dock", "sim_time": 9.0, "reason": "error 208: no way"}]
    return {
        "swarm_size": len(names),
        "world": "hall",
        "robot": "turtlebot3_waffle",
        "seed": 0,
        "sim_time": seconds,
        "real_time_factor": 4.0,
        "goals": {"sent": goals, "reached": goals - crash, "failed": int(crash), "pending": 0},
        "collisions": {"robot_robot": int(crash), "robot_world": 0},
        "min_clearance": 0.12,
        "makespan": float(seconds),
        "throughput_per_minute": 3.0,
        "trajectory_sha256": "0123456789abcdef" * 4,
        "cpu_ms_per_robot_second": {"world": 5.0, "navigators": 9.0, "total": 14.0},
        "breaches": {
            "collisions": crashes if crash else [],
            "missed_goals": missed if crash else [],
            "unfinished_goals": [],
        },
        "robots": {name: {"goals_reached": 2, "distance": 10.0} for name in names},
        "exit_code": int(crash),
        "failures": [],
    }
