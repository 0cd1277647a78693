"""Measure what the viewer costs: CPU of world, robots and viewer, and what pages receive.

Usage: python tools/viewer_load.py [--robots 5,20,100] [--pages 0,1,3] [--seconds 20]

Starts `swarm-up --viewer --speed 1` with each number of robots, opens pages that only listen
(a page's drawing depends on the reader's GPU), and prints a table in Markdown. Each robot is sent
through `loading_route`. The cores that a row names are those of this machine.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgspec.msgpack
import psutil
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from swarm_common.model.robot_names import RobotNames

START_LIMIT = 600.0  # [s] for the swarm to be active
SETTLE = 6.0  # [s] after pages were opened or closed
CAMERA = {  # as close to robots as that of a page that follows one: their wheels turn
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (-1.2, -2.4, 3.2),
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 800,
    "image_width": 1280,
}


class SilentPage:
    """A page that receives everything and draws nothing; counts updates and bytes."""

    def __init__(self, link: str, robot: str) -> None:
        self.updates = self.size = 0
        where = urlsplit(link)
        address = f"ws://{where.netloc}/?{where.query}&robot={robot}"
        protocol = f"viser-v{viser.__version__}"
        self._socket: ClientConnection = connect(
            address,
            subprotocols=[protocol],  # type: ignore[list-item]
            origin=f"http://{where.netloc}",  # type: ignore[arg-type]
            max_size=None,
            compression=None,
        )
        self._socket.send(msgspec.msgpack.encode(CAMERA))
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for data in self._socket:
                self.updates += 1
                self.size += len(data)

    def close(self) -> None:
        """Leave."""
        self._socket.close()


class Run:
    """A swarm with a viewer."""

    def __init__(self, robots: int, folder: Path, *options: str) -> None:
        """Start it with more options of swarm-up; wait until all robots are active."""
        self._log = folder / "up.log"
        command = f"--swarm-size {robots} --mission loading_route --viewer --port 0 --no-report"
        program = str(Path(sys.executable).with_name("swarm-up"))
        self._process = subprocess.Popen(
            [program, *command.split(), *options, "--run-dir", str(folder / "run")],
            stdout=self._log.open("w"),
            stderr=subprocess.STDOUT,
        )
        self._robots = robots
        self._wait_until_active()
        kinds = {"world": "swarm_sim.ros.node", "viewer": "swarm_view.process"}
        children = psutil.Process(self._process.pid).children(recursive=True)
        self._groups: dict[str, list[psutil.Process]] = {name: [] for name in (*kinds, "robots")}
        for child in children:
            words = " ".join(child.cmdline())
            name = next((name for name, module in kinds.items() if module in words), "robots")
            self._groups[name].append(child)

    def _wait_until_active(self) -> None:
        end = time.monotonic() + START_LIMIT
        while f"active {self._robots}/{self._robots}" not in self._log.read_text(encoding="utf-8"):
            if self._process.poll() is not None or time.monotonic() > end:
                raise SystemExit(f"the swarm did not start:\n{self._log.read_text()[-2000:]}")
            time.sleep(0.5)

    @property
    def link(self) -> str:
        """Address of the viewer, with its token."""
        found = re.search(r"viewer: (http://\S+)", self._log.read_text(encoding="utf-8"))
        assert found is not None
        return found[1]

    def cpu(self) -> dict[str, float]:
        """Return the CPU time [s] of each group so far."""
        return {
            name: sum(sum(process.cpu_times()[:2]) for process in group)
            for name, group in self._groups.items()
        }

    def real_time_factor(self) -> float:
        """Return the real-time factor that the terminal showed last."""
        found = re.findall(r"([\d.]+)x real time", self._log.read_text(encoding="utf-8"))
        return float(found[-1]) if found else 0.0

    def stop(self) -> None:
        """End it."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(60.0)


def measure(run: Run, robots: int, pages: int, seconds: float) -> dict[str, Any]:
    """Return one row."""
    open_pages = [SilentPage(run.link, name) for name in RobotNames().first(pages)]
    time.sleep(SETTLE)
    cpu, started = run.cpu(), time.monotonic()
    updates = [page.updates for page in open_pages]
    sizes = [page.size for page in open_pages]
    time.sleep(seconds)
    passed = time.monotonic() - started
    later = run.cpu()
    row: dict[str, Any] = {"robots": robots, "pages": pages, "rtf": run.real_time_factor()}
    row |= {f"cpu_{name}": 100.0 * (later[name] - cpu[name]) / passed for name in cpu}
    count = max(1, pages)
    row["updates"] = sum(p.updates - u for p, u in zip(open_pages, updates, strict=True)) / count
    row["rate"] = sum(p.size - s for p, s in zip(open_pages, sizes, strict=True)) / count
    row["updates"] /= passed
    row["rate"] /= 1000.0 * passed
    for page in open_pages:
        page.close()
    time.sleep(SETTLE)
    return row


HEAD = (
    "| robots | pages | updates per s and page | kB/s per page | viewer [% of a core] |"
    " world [%] | robots [%] | real-time factor |"
)


def line(row: dict[str, Any]) -> str:
    """Return a row of the table."""
    return (
        f"| {row['robots']} | {row['pages']} | {row['updates']:.1f} | {row['rate']:.0f} |"
        f" {row['cpu_viewer']:.1f} | {row['cpu_world']:.1f} | {row['cpu_robots']:.0f} |"
        f" {row['rtf']:.2f} |"
    )


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--robots", default="5,20,100")
    parser.add_argument("--pages", default="0,1,3")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--json", type=Path, help="also write the rows to this file")
    options = parser.parse_args()
    print(HEAD)
    print("|" + "---|" * (HEAD.count("|") - 1))
    rows = []
    for robots in map(int, options.robots.split(",")):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(robots, Path(folder))
            try:
                for pages in map(int, options.pages.split(",")):
                    rows.append(measure(run, robots, pages, options.seconds))
                    print(line(rows[-1]), flush=True)
            finally:
                run.stop()
    if options.json is not None:
        options.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
