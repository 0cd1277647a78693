"""A result of the bench with chosen fields."""

from typing import Any

from swarm_run.record.run_record import RunRecord

FIELDS: dict[str, Any] = {
    "scenario": "slim_blockage", "method": "ours", "robots": 20, "seed": 0, "engine": "planar",
    "conditions": {"loss": 0.0, "delay": 0.0, "lidar": False, "noise": 0.02},
    "goals_sent": 160, "goals_reached": 160, "goals_failed": 0, "robot_robot": 0,
    "robot_world": 0, "first_collision": "", "first_miss": "", "near_misses": 0,
    "min_clearance": 0.1, "min_held_gap": 0.56, "min_held_slack": -0.01, "makespan": 600.0,
    "throughput_per_minute": 16.0, "sim_time": 600.0, "hold_time": 10.0, "wait_time": 20.0,
    "wait_median": 1.0, "wait_worst": 5.0, "goal_median": 60.0, "goal_worst": 120.0,
    "fairness": 2.0, "pushes": 3, "retreats": 1, "deadlocks_resolved": 2, "replans": 30,
    "recoveries": 0, "wall_time": 9.0, "tick_us_median": 90.0, "tick_us_p99": 300.0,
    "trajectory_sha256": "0", "per_robot": {},
}  # fmt: skip


def result(**changes: Any) -> RunRecord:
    return RunRecord(**(FIELDS | changes))
