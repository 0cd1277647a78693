"""`swarm-up` as a process, over fakes of the world, the navigators and the mission."""

import contextlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil

ROOT = Path(__file__).resolve().parents[2]
DOMAIN = os.environ["ROS_DOMAIN_ID"]


class Up:
    """Starts swarm-up in a folder; knows what it left running, and ends it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.run_dir = folder / "run"
        self._started: list[subprocess.Popen[str]] = []

    def start(self, *flags: str, **moods: str) -> subprocess.Popen[str]:
        variables = {f"FAKE_{name.upper()}": mood for name, mood in moods.items()}
        command = (sys.executable, "-P", "-m", "tests.fakes.plain.up", "--swarm-size", "3")
        process = subprocess.Popen(
            (*command, "--run-dir", str(self.run_dir), *flags),
            env=os.environ | variables | {"ROS_DOMAIN_ID": DOMAIN, "PYTHONPATH": str(ROOT)},
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._started.append(process)
        return process

    def run(self, *flags: str, **moods: str) -> tuple[int, str, str]:
        process = self.start(*flags, **moods)
        output, errors = process.communicate(timeout=100)
        return process.returncode, output, errors

    def report(self) -> dict[str, Any]:
        report = json.loads((self.run_dir / "report.json").read_text(encoding="utf-8"))
        return report

    def left_running(self) -> list[str]:
        return list(self._running().values())

    def _running(self) -> dict[psutil.Process, str]:
        """Return the processes that name the run's folder, with their command lines."""
        found = {}
        for process in psutil.process_iter():
            with contextlib.suppress(psutil.Error):
                line = " ".join(process.cmdline())
                if str(self.run_dir) in line:
                    found[process] = line
        return found

    def end(self) -> list[str]:
        """End what a failed test left: the next one has the same domain.

        Returns:
            The command lines of what outlived swarm-up itself; they were killed, too.
        """
        for started in self._started:
            started.kill()
            started.wait()
            for stream in (started.stdout, started.stderr):
                if stream is not None:
                    stream.close()
        deadline = time.monotonic() + 20.0
        while self.left_running() and time.monotonic() < deadline:
            time.sleep(0.05)
        left = self._running()
        for process in left:
            with contextlib.suppress(psutil.Error):
                process.kill()
        return list(left.values())


def wait_for(condition: Any) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


MISSION = ("--mission", "loading_route", "--until-done")
