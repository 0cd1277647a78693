"""Capture the viewer's pictures in docs/ from a real run, in a headless browser.

Usage: python -m tools.viewer_pictures [--robots 20] [--frames 80] [--out docs] [--recording RUN]
With --recording the run is one that was made with `swarm-up --record`; else it is started here.
Needs Debian's packages chromium and chromium-driver, and the extra `dev`.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
import threading
import time
from pathlib import Path

import rclpy
from PIL import Image
from rclpy.node import Node
from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState, StepSimulation

from swarm_common.middleware import ros_env
from swarm_common.model.palette import STATES
from swarm_common.model.records import CONTROL_PERIOD
from swarm_recording.bag_feed import BagFeed
from swarm_view.server.server import Server
from swarm_view.viewer import Viewer
from tools.report_picture import open_chromium
from tools.viewer_load import Run

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--disable-dev-shm-usage",
    "--enable-unsafe-swiftshader",
)
SCREEN = {"width": 1600, "height": 900, "deviceScaleFactor": 2, "mobile": False}  # 2: smooth edges
WARM_UP_TICKS = 900  # before the first picture
FRAME_TICKS = 4  # of the GIF; played at 10 frames per second it is 4 times real time
GIF_WIDTH = 1000
GIF_COLORS = 96
SWATCH = 24  # [px]
REST = 20.0  # [s] until names and the panel are there, too
TIDY = (
    """document.querySelectorAll('.mantine-Notification-closeButton').forEach((x) => x.click());"""
)


class FilmedSwarm:
    """A paused swarm that is stepped from picture to picture."""

    def __init__(self, robots: int, folder: Path) -> None:
        self._run = Run(robots, folder, "--speed", "max")
        self.address = self._run.link
        ros_env.set_defaults()
        rclpy.init()
        self._node = Node("photographer")
        make = self._node.create_client
        self._set = make(SetSimulationState, "/sim/set_simulation_state")
        self._step = make(StepSimulation, "/sim/step_simulation")
        paused = SimulationState(state=SimulationState.STATE_PAUSED)
        self._call(self._set, SetSimulationState.Request(state=paused))

    def _call(self, client, request) -> None:  # type: ignore[no-untyped-def]
        client.wait_for_service()
        rclpy.spin_until_future_complete(self._node, client.call_async(request))

    def step(self, ticks: int) -> None:
        """Let the world go on."""
        self._call(self._step, StepSimulation.Request(steps=ticks))

    def stop(self) -> None:
        """End it."""
        rclpy.shutdown()
        self._run.stop()


class Replay:
    """A recorded run that is stepped from picture to picture."""

    def __init__(self, run: Path) -> None:
        """Open it."""
        feed, server = BagFeed(run), Server("127.0.0.1", 0)
        self._viewer = Viewer(server, feed, None, feed)
        self._loop, self._feed = server.viser.get_event_loop(), feed
        self._thread = threading.Thread(target=self._viewer.run)
        self._thread.start()
        self.address = server.url()

    def step(self, ticks: int) -> None:
        """Let time go on."""
        time_there = self._feed.now + ticks * CONTROL_PERIOD
        self._loop.call_soon_threadsafe(lambda: self._feed.seek(time_there))

    def stop(self) -> None:
        """Close it."""
        self._viewer.stop()
        self._thread.join()
        self._viewer.close()


def open_browser() -> webdriver.Chrome:
    """Return a browser without a window."""
    browser = open_chromium(FLAGS)
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SCREEN)  # a window has edges
    browser.set_script_timeout(120)
    browser.set_page_load_timeout(120)
    return browser


def picture(browser: webdriver.Chrome, settle: float) -> Image.Image:
    """Return what the page looks like when it has come to rest."""
    time.sleep(settle)
    while True:
        try:
            taken = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
            return taken.reduce(2)
        except WebDriverException:
            time.sleep(1.0)


def visit(browser: webdriver.Chrome, address: str) -> None:
    """Open a page and wait until it shows something."""
    browser.get(address)
    for _ in range(200):
        try:
            text = browser.execute_script("return document.body.innerText")
            if "answering" in text or "estimate" in text:  # of the swarm, of one robot
                browser.execute_script(TIDY)
                return
        except WebDriverException:
            pass
        time.sleep(0.5)
    raise SystemExit(f"{address} shows nothing")


def main() -> int:
    """Capture the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--frames", type=int, default=80)
    parser.add_argument("--recording", type=Path, help="folder of a run made with --record")
    parser.add_argument("--out", type=Path, default=Path("docs"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recording = options.recording
        stage = Replay(recording) if recording else FilmedSwarm(options.robots, Path(folder))
        browser = open_browser()
        try:
            stage.step(WARM_UP_TICKS)
            visit(browser, stage.address)
            stage.step(10)
            picture(browser, REST).save(options.out / "viewer.png", optimize=True)
            browser.execute_script("swarm.send('key', 'p')")  # to the plan
            picture(browser, 5.0)
            frames = []
            for _ in range(options.frames):
                stage.step(FRAME_TICKS)
                frames.append(picture(browser, 0.4))
            save_gif(frames, options.out / "viewer.gif")
            visit(browser, f"{stage.address}&dark=1")
            stage.step(10)
            picture(browser, REST).save(options.out / "viewer_dark.png", optimize=True)
            visit(browser, f"{stage.address}&robot=Srobot3")
            for _ in range(4):
                stage.step(10)
                time.sleep(1.0)
            picture(browser, REST).save(options.out / "viewer_robot.png", optimize=True)
        finally:
            browser.quit()
            stage.stop()
    return 0


def save_gif(frames: list[Image.Image], path: Path) -> None:
    """Write frames as a GIF of the page, with its panel and time line."""
    height = round(GIF_WIDTH * frames[0].height / frames[0].width)
    small = [frame.resize((GIF_WIDTH, height), Image.Resampling.LANCZOS) for frame in frames]
    sample = small[0].copy()
    for place, color in enumerate(STATES.values()):  # robots are small, and their colours matter
        sample.paste(color, (SWATCH * place, 0, SWATCH * (place + 1), SWATCH))
    palette = sample.quantize(GIF_COLORS, kmeans=3)
    indexed = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in small]
    indexed[0].save(
        path, save_all=True, append_images=indexed[1:], duration=100, loop=0, optimize=True
    )


if __name__ == "__main__":
    sys.exit(main())
