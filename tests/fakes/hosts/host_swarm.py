"""`swarm-up --role` on hosts of this machine, as its users would start it."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from tests.fakes.hosts.net_hosts import NetHosts

ROOT = Path(__file__).resolve().parents[3]
SECRET = "between-hosts-of-a-test"
DOMAIN = "7"  # each host has a network of its own, and so all domains
SWARM_UP = "import sys; from swarm_commander.cli.main import swarm_up; sys.exit(swarm_up())"
TIME = re.compile(r"t = ([0-9.]+) s \|")


class HostSwarm:
    """The world on host 1, robots on the others."""

    def __init__(self, hosts: int, folder: Path, *, with_relay: bool = False) -> None:
        self.net = NetHosts(hosts, with_relay=with_relay)
        self.folder = folder
        self._processes: dict[int, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> HostSwarm:
        self.net.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            for process in self._processes.values():
                process.kill()
                process.wait()
            time.sleep(0.2)
            for pid in self.net.pids():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        finally:
            self.net.__exit__(kind, error, trace)

    def start_world(self, *flags: str) -> None:
        self.start(1, "--role", "world", "--bind", self.net.address(1), "--no-report", *flags)

    def start_robots(self, host: int, robots: str, *flags: str) -> None:
        world = self.net.address(1)
        self.start(host, "--role", "robots", "--robots", robots, "--connect", world, *flags)

    def start(self, host: int, *flags: str, secret: str = SECRET) -> None:
        """Start swarm-up on a host; with an empty secret, none is given."""
        command = (sys.executable, "-c", SWARM_UP, *flags, "--run-dir", str(self.run(host)))
        foreign = ("FASTRTPS_DEFAULT_PROFILES_FILE", "ROS_AUTOMATIC_DISCOVERY_RANGE")
        environment = {name: text for name, text in os.environ.items() if name not in foreign}
        own = {"SWARM_SECRET": secret} if secret else {}
        with self._log(host).open("wb") as output:
            self._processes[host] = subprocess.Popen(
                self.net.command(host, *command),
                env=environment | {"ROS_DOMAIN_ID": DOMAIN, "PYTHONPATH": str(ROOT)} | own,
                cwd=self.folder,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    def run(self, host: int) -> Path:
        return self.folder / f"run_{host}"

    def report(self, host: int) -> dict[str, Any]:
        report = json.loads((self.run(host) / "report.json").read_text(encoding="utf-8"))
        return report

    def said(self, host: int) -> str:
        return self._log(host).read_text(encoding="utf-8")

    def wait_for(self, host: int, words: str, limit: float) -> None:
        end = time.monotonic() + limit
        while words not in self.said(host):
            assert time.monotonic() < end, f"never said '{words}':\n{self.said(host)}"
            assert self._processes[host].poll() is None, self.said(host)
            time.sleep(0.1)

    def wait_until(self, sim_time: float, limit: float) -> None:
        end = time.monotonic() + limit
        while self.sim_time() < sim_time:
            assert time.monotonic() < end, self.said(1)
            assert self._processes[1].poll() is None, self.said(1)
            time.sleep(0.1)

    def sim_time(self) -> float:
        """Return the simulated time that the world said last [s]."""
        times = TIME.findall(self.said(1))
        return float(times[-1]) if times else 0.0

    def interrupt(self, host: int) -> None:
        self._processes[host].send_signal(signal.SIGINT)

    def kill(self, host: int) -> None:
        for pid in self.net.pids_on(host):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self._processes[host].wait()

    def exit_code(self, host: int, limit: float) -> int:
        """Wait for the end of a host's swarm-up; return its exit code."""
        try:
            return self._processes[host].wait(limit)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"host {host} goes on:\n{self.said(host)}") from None

    def assert_nothing_is_left(self) -> None:
        time.sleep(0.3)
        assert self.net.pids() == []

    def _log(self, host: int) -> Path:
        return self.folder / f"host_{host}.log"
