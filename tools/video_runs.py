"""Record the runs that the video in docs/ is drawn from: real swarms, each with its processes.

Usage: python -m tools.video_runs FOLDER [hall crossing dead hundred]
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil

from swarm_common.files.journal import read_journal
from swarm_common.model.robot_names import RobotNames

UP = (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()")
COMMON = "--headless --speed max --record --record-rate 5 --no-report"
HALL = "--swarm-size 20 --mission loading_route --record-topics status,beacon"
RUNS = {
    "hall": f"{HALL} --until-done",
    "crossing": "--world crossing --swarm-size 24 --mission change_arms --until-done"
    " --record-topics status,beacon",
    "dead": "--swarm-size 10 --mission loading_route --drive planar --no-restart --duration 140"
    " --record-topics status,beacon",
    "hundred": "--world warehouse --swarm-size 100 --mission warehouse_orders --drive planar"
    " --duration 200 --record-topics status",
}
KILL_AT = 45.0  # [s] of simulated time
AISLE_MAP = (-6.6, 2.0)  # [m] in the west aisle, where robots pass in both directions


def record(name: str, folder: Path) -> int:
    """Run a swarm; return its exit code. In `dead` a navigator is killed on the way."""
    run = folder / name
    with (folder / f"{name}.log").open("w") as log:
        command = [*UP, *COMMON.split(), *RUNS[name].split(), "--run-dir", str(run)]
        swarm = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
    try:
        if name == "dead":
            victim = _kill_one(swarm, run)
            (folder / "dead.json").write_text(json.dumps(victim))
        return swarm.wait()
    finally:
        if swarm.poll() is None:
            swarm.send_signal(signal.SIGINT)
            swarm.wait(60.0)


def _kill_one(swarm: subprocess.Popen[bytes], run: Path) -> dict[str, object]:
    """Kill the navigator of the robot nearest to the aisle's middle, when it is time."""
    while swarm.poll() is None:
        lines = [line for line in read_journal(run / "trace" / "world.jsonl") if "x" in line]
        if lines and lines[-1]["t"] >= KILL_AT:
            x, y = lines[-1]["x"], lines[-1]["y"]
            apart = [
                (a / 1000.0 - AISLE_MAP[0]) ** 2 + (b / 1000.0 - AISLE_MAP[1]) ** 2
                for a, b in zip(x, y, strict=True)
            ]
            robot = RobotNames().name_of(apart.index(min(apart)) + 1)
            for process in psutil.Process(swarm.pid).children(recursive=True):
                if _log_of(process.pid) == robot:
                    process.send_signal(signal.SIGKILL)
                    return {"robot": robot, "sim_time": lines[-1]["t"]}
        time.sleep(0.2)
    raise SystemExit(f"the swarm in {run} ended before {KILL_AT} s")


def _log_of(pid: int) -> str:
    try:
        return Path(os.readlink(f"/proc/{pid}/fd/1")).stem
    except OSError:
        return ""


def main() -> int:
    """Record the runs that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(RUNS)}; default: all")
    options = parser.parse_args()
    if unknown := set(options.names) - set(RUNS):
        parser.error(f"no run {', '.join(sorted(unknown))}; there are {', '.join(RUNS)}")
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.names or RUNS:
        print(f"{name}: exit code {record(name, options.folder)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
