"""Measure what 25 frames a second cost the viewer, without ROS and whatever else the machine does.

Usage, from the root of the checkout: python -m tools.viewer_frames [--robots 100] [--pages 1,3]

The robots are those of `tests/fakes/moving_feed.py`. Their clock goes on by 0.04 s from frame to
frame, however long that takes, and CPU seconds are counted per second of that clock.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
import time

import psutil

from swarm_view.server.server import Server
from swarm_view.viewer import FRAME_PERIOD, Viewer
from tests.fakes.moving_feed import MovingFeed
from tools.viewer_load import SilentPage

WARM_UP = 100  # frames
START = 100.0  # [s] of the frames' clock
PAUSE = 0.045  # [s] of wall time between two frames, in which viser sends


class MeteredFeed(MovingFeed):
    """Robots whose own cost is known.

    Attributes:
        cost: [s] of CPU spent on making messages.
    """

    def __init__(self, count: int) -> None:
        """Stand at time zero."""
        self.time = self.cost = 0.0
        super().__init__(count, clock=lambda: self.time)
        self._known = super().topics()

    def topics(self) -> dict[str, str]:
        """Return all topics."""
        return self._known

    def take(self) -> list[tuple[str, bytes]]:
        """Return what is new."""
        began = time.thread_time()
        taken = super().take()
        self.cost += time.thread_time() - began
        return taken


async def measure(viewer: Viewer, feed: MeteredFeed, pages: int, frames: int) -> float:
    """Return the CPU seconds per second of the frames' clock, without the feed's."""
    while viewer.pages < pages:
        await asyncio.sleep(0.1)
    process, used = psutil.Process(), 0.0
    for frame in range(WARM_UP + frames):
        if frame == WARM_UP:
            used = sum(process.cpu_times()[:2]) - feed.cost
        feed.time += FRAME_PERIOD
        viewer.frame(START + feed.time)
        await asyncio.sleep(PAUSE)
    used = sum(process.cpu_times()[:2]) - feed.cost - used
    return float(used) / (frames * FRAME_PERIOD)


def show(robots: int, pages: int, frames: int) -> None:
    """Measure in this process, with the pages in another one, and print a line."""
    feed = MeteredFeed(robots)
    server = Server("127.0.0.1", 0)
    viewer = Viewer(server, feed, None)
    if not os.fork():
        opened = [SilentPage(server.url(), f"Srobot{i + 1}") for i in range(pages)]
        while opened and os.getppid() != 1:
            time.sleep(0.5)
        os._exit(0)
    loop = server.viser.get_event_loop()
    job = asyncio.run_coroutine_threadsafe(measure(viewer, feed, pages, frames), loop)
    sys.stdout.write(f"{robots} robots, {pages} pages: {100.0 * job.result():.1f} % of a core\n")


def main() -> int:
    """Measure each number of pages in a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--robots", type=int, default=100)
    parser.add_argument("--pages", default="1,3")
    parser.add_argument("--frames", type=int, default=300)
    options = parser.parse_args()
    for pages in map(int, options.pages.split(",")):
        child = os.fork()
        if not child:
            show(options.robots, pages, options.frames)
            sys.stdout.flush()
            os._exit(0)
        os.waitpid(child, 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
