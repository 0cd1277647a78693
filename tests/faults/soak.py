"""An hour of a swarm whose navigators are killed every minute: does anything grow?

python -m tests.faults.soak --minutes 60 [--robots 20] [--speed 1] [--output soak.json]

It drives the loading route over and over, in real time, and writes its figures once a minute, so
that what was measured is there whatever ends it. Exit code 0 if memory, file descriptors and
threads are flat, nobody collided and every killed navigator came back.
"""

import argparse
import contextlib
import json
import random
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import psutil

from tests.fakes.real_swarm import RealSwarm
from tests.fakes.ros_domains import reserved_domain

PERIOD = 60.0  # [s] of wall time between two faults
LAPS = 1000  # more than an hour holds
SETTLED = 0.2  # share of the samples at the start that is not compared: caches fill
GROWTH = {"rss_mb": 1.05, "fds": 1.02, "threads": 1.02}  # from the first to the last third
COMPONENTS = ("swarm-up", "world", "mission", "fork_server")


def sample(swarm: RealSwarm, began: float) -> dict[str, Any]:
    """Return what the processes hold now: resident memory, file descriptors, threads."""
    processes = {name: swarm.pid_of(name) for name in COMPONENTS}
    navigators = swarm.navigators()
    figures = {name: _held([pid]) for name, pid in processes.items() if pid is not None}
    figures["navigators"] = _held(list(navigators.values()))
    return {
        "minute": round((time.monotonic() - began) / 60.0, 2),
        "sim_time": swarm.sim_time(),
        "navigators_alive": len(navigators),
        "held": figures,
    }


def _held(pids: Sequence[int]) -> dict[str, float]:
    held = {"rss_mb": 0.0, "fds": 0.0, "threads": 0.0}
    for pid in pids:
        with contextlib.suppress(psutil.Error):
            process = psutil.Process(pid)
            held["rss_mb"] += process.memory_info().rss / 2.0**20
            held["fds"] += process.num_fds()
            held["threads"] += process.num_threads()
    return {name: round(value, 1) for name, value in held.items()}


def growth(samples: Sequence[dict[str, Any]], robots: int) -> dict[str, dict[str, float]]:
    """Return last third over first third (medians), once caches are filled and all are there."""
    whole = [each for each in samples if each["navigators_alive"] == robots]
    rest = whole[int(SETTLED * len(whole)) :]
    third = len(rest) // 3
    if third < 1:
        return {}
    return {
        component: {
            name: round(
                _median(rest[-third:], component, name) / _median(rest[:third], component, name), 4
            )
            for name in GROWTH
        }
        for component in (*COMPONENTS, "navigators")
    }


def _median(samples: Sequence[dict[str, Any]], component: str, name: str) -> float:
    values = [each["held"][component][name] for each in samples if component in each["held"]]
    return statistics.median(values) or 1.0


def is_flat(grown: dict[str, dict[str, float]]) -> bool:
    return bool(grown) and all(
        value <= GROWTH[name] for figures in grown.values() for name, value in figures.items()
    )


def run(options: argparse.Namespace) -> int:
    """Run the soak; return the exit code."""
    rng = random.Random(options.seed)
    output = Path(options.output)
    result: dict[str, Any] = {"options": vars(options), "kills": [], "samples": []}
    folder = tempfile.mkdtemp(prefix="soak_", dir=options.folder)  # kept: its logs say what broke
    result["folder"] = folder
    with reserved_domain() as domain:
        flags = ("--swarm-size", str(options.robots), "--seed", str(options.seed))
        flags += ("--mission", "loading_route", "--laps", str(LAPS), "--headless", "--no-report")
        flags += ("--speed", str(options.speed))
        swarm = RealSwarm(Path(folder), domain, *flags)
        try:
            swarm.wait_until(lambda: swarm.sim_time() > 0.0)
            result["state"] = "running"
            began = time.monotonic()
            due = began + PERIOD  # all have begun to drive by then
            while swarm.is_running() and time.monotonic() - began < 60.0 * options.minutes:
                time.sleep(1.0)
                if time.monotonic() < due:
                    continue
                due += PERIOD
                result["samples"].append(sample(swarm, began))
                if not (alive := sorted(swarm.navigators().items())):
                    continue
                robot, pid = rng.choice(alive)
                number = signal.SIGSTOP if len(result["kills"]) % 5 == 4 else signal.SIGKILL
                if swarm.send(robot, number):
                    kill = {"robot": robot, "pid": pid, "signal": signal.Signals(number).name}
                    result["kills"].append(kill | {"sim_time": swarm.sim_time()})
                output.write_text(json.dumps(result, indent=1), encoding="utf-8")
            time.sleep(min(30.0, PERIOD))  # for the last to come back
            result["samples"].append(sample(swarm, began))
            swarm.popen.send_signal(signal.SIGINT)
            result["exit_code"] = swarm.wait_for_end()
            report = swarm.report()
            kept = ("collisions", "goals", "restarts", "incidents", "failures", "has_verdict")
            result["report"] = {
                name: report[name] for name in (*kept, "sim_time", "late_ticks", "wall_time")
            }
            result["output"] = swarm.output[-4000:]
        finally:
            swarm.close()
        swarm.check_nothing_left()
    grown = growth(result["samples"], options.robots)
    no_collision = set(result["report"]["collisions"].values()) == {0}
    all_back = result["samples"][-1]["navigators_alive"] == options.robots
    is_good = is_flat(grown) and no_collision and all_back and result["exit_code"] == 0
    result |= {"state": "ended", "growth": grown, "all_back": all_back, "is_good": is_good}
    output.write_text(json.dumps(result, indent=1), encoding="utf-8")
    return 0 if is_good else 1


def main() -> None:
    """Read the command line, and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0, help="of wall time")
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--speed", default="1", help="times real time")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", default="soak.json")
    parser.add_argument("--folder", default=None, help="for the run; default: a temporary one")
    sys.exit(run(parser.parse_args()))


if __name__ == "__main__":
    main()
