"""Measure how many frames a second a browser draws of a page, on software rendering.

Usage: python -m tools.page_frames [--robots 100] [--sizes 1600x900,800x450] [--seconds 20]

The robots are those of `tests/fakes/moving_feed.py`, all on one page, seen from the preset *Hall*.
Needs Debian's packages chromium and chromium-driver, and the extra `dev`. Whatever else the machine
does slows the browser down: the load is printed beside the figures, and the CPU time that the
browser spent on a frame, which suffers less.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
import time

import psutil
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

from swarm_view.server.server import Server
from swarm_view.viewer import Viewer
from tests.fakes.moving_feed import MovingFeed

FLAGS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
)  # fmt: skip
LIMIT = 180.0  # [s] for the page to show all robots
SETTLE = 10.0  # [s] for models, names and the camera
COUNT = """
const [seconds, done] = arguments, gl = document.querySelector('canvas').getContext('webgl2');
const pixel = new Uint8Array(4), begun = performance.now();
let frames = 0;
function next(now) {
  gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);  // waits until it is drawn
  frames += 1;
  if (now - begun < 1000 * seconds) requestAnimationFrame(next);
  else done(1000 * frames / (performance.now() - begun));
}
requestAnimationFrame(next);
"""


def rate(browser: webdriver.Chrome, size: str, seconds: float) -> tuple[float, float]:
    """Return the frames per second of the page that is open, and CPU seconds per frame.

    Args:
        size: Of it, like 1600x900.
        seconds: [s] to count.
    """
    width, height = map(int, size.split("x"))
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_script(
        "[...document.querySelectorAll('button')].find((b) => b.innerText === 'Hall')?.click()"
    )
    time.sleep(SETTLE)
    used, started = cpu_seconds(browser), time.monotonic()
    frames = float(browser.execute_async_script(COUNT, seconds))
    used = (cpu_seconds(browser) - used) / (time.monotonic() - started)
    return frames, used / frames


def cpu_seconds(browser: webdriver.Chrome) -> float:
    """Return the CPU seconds of all processes of a browser so far."""
    root = psutil.Process(browser.service.process.pid)
    return float(sum(sum(child.cpu_times()[:2]) for child in root.children(recursive=True)))


def main() -> int:
    """Measure each size of the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--robots", type=int, default=100)
    parser.add_argument("--sizes", default="1600x900,800x450")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    server = Server("127.0.0.1", 0)
    viewer = Viewer(server, MovingFeed(options.robots), None)
    drawing = threading.Thread(target=viewer.run)
    drawing.start()
    setup = Options()
    setup.binary_location = "/usr/bin/chromium"
    try:
        with tempfile.TemporaryDirectory() as profile:
            for flag in (*FLAGS, f"--user-data-dir={profile}"):
                setup.add_argument(flag)
            with webdriver.Chrome(setup, Service("/usr/bin/chromedriver")) as browser:
                browser.set_script_timeout(options.seconds + LIMIT)
                browser.get(server.url())
                end = time.monotonic() + LIMIT
                shown = f"{options.robots}, {options.robots} answering"
                while shown not in browser.execute_script("return document.body.innerText"):
                    if time.monotonic() > end:
                        raise SystemExit(f"the page does not show: {shown}")
                    time.sleep(0.5)
                for size in options.sizes.split(","):
                    frames, cpu = rate(browser, size, options.seconds)
                    load = os.getloadavg()[0]
                    sys.stdout.write(
                        f"{options.robots} robots, {size}: {frames:.1f} frames per second,"
                        f" {cpu:.3f} s of CPU a frame (load of the machine {load:.1f})\n"
                    )
    finally:
        viewer.stop()
        drawing.join(20.0)
        viewer.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
