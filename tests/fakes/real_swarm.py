"""A real `swarm-up` with all its processes, to kill and stop them from outside."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import psutil
import pytest

from swarm_common.middleware.ros_env import DOMAIN_PORTS, FIRST_PORT
from tests.fakes.programs import ROOT, run_program
from tests.fakes.ros_domains import reserved_domain

COMMAND = "from swarm_commander.cli.main import {0}; {0}()"
ROS2 = "from swarm_ros2.cli import main; main()"
MODULES = {
    "world": "swarm_sim.ros.node",
    "mission": "swarm_commander.mission.runner",
    "courier": "swarm_commander.mission.courier",
    "centre": "swarm_central.process",
    "fork_server": "swarm_nav.launch.fork_server_main",
    "recorder": "swarm_recording.recorder",
    "viewer": "swarm_view.process",
}
START_LIMIT = 300.0  # [s] of wall time on a busy machine
END_LIMIT = 120.0  # [s] likewise
SETTLE_LIMIT = 20.0  # [s] of wall time until what was killed is gone
SHARED = Path("/dev/shm")
TRACER = "lttng-ust-wait"  # two pages of LTTng's, which every user of rclpy shares for ever


class RealSwarm:
    """Starts `swarm-up`, finds its processes by what they are, and sees what is left of them."""

    def __init__(self, folder: Path, domain: int, *flags: str, **variables: str) -> None:
        """Start it; the run's folder is `folder`/run, the output goes to `folder`/up.log."""
        self.folder, self.run_dir = folder, folder / "run"
        self._log = folder / "up.log"
        self._domain = domain
        self._segments: set[str] = set()  # that its processes have had
        own = {"ROS_DOMAIN_ID": str(domain), "PYTHONPATH": str(ROOT)}
        self.environment = os.environ | own | variables
        with self._log.open("wb") as output:
            self.popen = subprocess.Popen(
                (*command("swarm_up"), "--run-dir", str(self.run_dir), *flags),
                cwd=folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    # Processes

    def pid_of(self, component: str) -> int | None:
        """Return the process id of swarm-up or of the first process with a name of `MODULES`."""
        if component == "swarm-up":
            return self.popen.pid
        for child in _children(self.popen.pid):
            with contextlib.suppress(psutil.Error):
                if MODULES[component] in child.cmdline():
                    return int(child.pid)
        return None

    def navigators(self) -> dict[str, int]:
        """Return the process ids of the navigators by robot: their output is in its log."""
        fork_server = self.pid_of("fork_server")
        found = {}
        for child in _children(fork_server) if fork_server is not None else ():
            with contextlib.suppress(OSError):
                log = Path(os.readlink(f"/proc/{child.pid}/fd/1"))
                if log.stem.startswith("Srobot"):
                    found[log.stem] = int(child.pid)
        return found

    def processes(self) -> list[psutil.Process]:
        with contextlib.suppress(psutil.Error):
            top = psutil.Process(self.popen.pid)
            return [top, *top.children(recursive=True)]
        return []

    def send(self, component: str, number: int) -> bool:
        """Send a signal to a component or, by its name, to a robot's navigator."""
        is_robot = component.startswith("Srobot")
        pid = self.navigators().get(component) if is_robot else self.pid_of(component)
        self._note_segments()
        if pid is None:
            return False
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)
            return True
        return False

    def _note_segments(self) -> None:
        """Remember the segments of shared memory that the processes have now."""
        for process in self.processes():
            with contextlib.suppress(OSError):
                text = Path(f"/proc/{process.pid}/maps").read_text(encoding="utf-8")
                lines = (line.split() for line in text.splitlines())
                paths = [Path(words[5]) for words in lines if len(words) > 5]
                self._segments |= {
                    path.name
                    for path in paths
                    if path.parent == SHARED and not path.name.startswith(TRACER)
                }

    # Progress

    @property
    def output(self) -> str:
        """What swarm-up has printed."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def run(self, name: str, *words: str) -> subprocess.CompletedProcess[str]:
        return run_program((*command(name), *words), self.environment, cwd=self.folder)

    def hurry(self) -> None:
        """Let it go on as fast as it can, once what has to happen at its pace has happened."""
        words = ("param", "set", "/sim/world", "speed", "0.0")
        run_program((sys.executable, "-c", ROS2, *words), self.environment, check=True)

    def wait_until_active(self) -> None:
        self.wait_until(lambda: "all robots are active" in self.output)

    def is_running(self) -> bool:
        return self.popen.poll() is None

    def sim_time(self) -> float:
        """Return the simulated time that is known to swarm-up [s]; 0 before the first."""
        with contextlib.suppress(OSError, ValueError, IndexError, KeyError):
            lines = (self.run_dir / "trace" / "usage.jsonl").read_text("utf-8").splitlines()
            return float(json.loads(lines[-1])["t"])
        return 0.0

    def wait_until(self, condition: Callable[[], object], limit: float = START_LIMIT) -> None:
        end = time.monotonic() + limit
        while not condition():
            assert self.is_running(), f"swarm-up has ended:\n{self.output}"
            assert time.monotonic() < end, f"waited in vain:\n{self.output}"
            time.sleep(0.1)

    def wait_for_end(self, limit: float = END_LIMIT) -> int:
        return int(self.popen.wait(limit))

    def good_report(self, limit: float = END_LIMIT) -> dict[str, Any]:
        """Return the report of a run that ends with exit code 0."""
        assert self.wait_for_end(limit) == 0, self.output
        return self.report()

    def report(self) -> dict[str, Any]:
        report = json.loads((self.run_dir / "report.json").read_text(encoding="utf-8"))
        return report

    # The end

    def left(self) -> list[str]:
        """Return what is left: processes, sockets, segments of shared memory."""
        mark = str(self.run_dir)
        names = [
            f"process {process.info['pid']} {process.info['cmdline']}"
            for process in psutil.process_iter(["pid", "cmdline"])
            if any(mark in part for part in process.info["cmdline"] or ())
        ]
        locks = Path("/proc/net/unix").read_text(encoding="utf-8")
        if f"@swarm-up-domain-{self._domain}\n" in locks:
            names.append("the lock of the ROS domain")
        first = FIRST_PORT + DOMAIN_PORTS * self._domain
        ports = range(first, first + DOMAIN_PORTS)
        names += [
            f"UDP port {item.laddr.port}"
            for item in psutil.net_connections("udp4")
            if item.laddr.port in ports and not is_test(item.pid)  # whose nodes may live on
        ]
        return names + [f"segment {name}" for name in self._segments if (SHARED / name).exists()]

    def check_nothing_left(self) -> None:
        end = time.monotonic() + SETTLE_LIMIT
        while (left := self.left()) and time.monotonic() < end:
            time.sleep(0.2)
        assert not left, left

    def close(self) -> None:
        """End it, whatever state it is in."""
        for process in self.processes():
            with contextlib.suppress(psutil.Error):
                process.send_signal(signal.SIGCONT)
        if self.is_running():
            self.popen.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.popen.wait(END_LIMIT / 2)
        self.popen.kill()
        self.popen.wait()


def is_test(pid: int | None) -> bool:
    """Whether a process is a run of tests, this one or one beside it."""
    with contextlib.suppress(psutil.Error):
        return pid is not None and any(
            "pytest" in Path(part).name for part in psutil.Process(pid).cmdline()[:4]
        )
    return False


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., RealSwarm]]:
    """Yield a function that starts a swarm; at the end nothing may be left of any."""
    with contextlib.ExitStack() as stack:

        def begin(*flags: str, **variables: str) -> RealSwarm:
            domain = stack.enter_context(reserved_domain())
            folder = tmp_path / str(domain)
            folder.mkdir()
            swarm = RealSwarm(folder, domain, *flags, **variables)
            stack.callback(swarm.check_nothing_left)
            stack.callback(swarm.close)
            return swarm

        yield begin


def command(name: str) -> tuple[str, ...]:
    return (sys.executable, "-c", COMMAND.format(name))


def check_is_true(code: int, report: Mapping[str, Any]) -> None:
    """Check that exit code and report say the same, and no more than is known."""
    assert report["exit_code"] == code
    goals = report["goals"]
    robots = report["robots"].values()
    assert goals["reached"] == sum(robot["goals_reached"] for robot in robots)
    assert goals["failed"] == sum(robot["goals_failed"] for robot in robots)
    assert goals["failed"] == len(report["breaches"]["missed_goals"])
    assert min(goals.values()) >= 0
    if not report["has_verdict"]:
        assert code == 3
    if code == 0:
        assert report["failures"] == []
        assert goals["failed"] == 0
        assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    if code == 3:
        assert report["failures"]


def _children(pid: int) -> list[psutil.Process]:
    with contextlib.suppress(psutil.Error):
        return list(psutil.Process(pid).children())
    return []
