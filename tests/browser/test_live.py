"""The viewer of a real swarm in a real browser: a click on the floor sends a robot there."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium.webdriver.remote.webdriver import WebDriver

from tests.browser.page import click_canvas, errors, press, text_of, wait_for
from tests.graph.conftest import reserved_domain

pytestmark = [pytest.mark.long, pytest.mark.timeout(500)]
ROOT = Path(__file__).resolve().parents[2]
UP = "from swarm_commander.cli import swarm_up; swarm_up()"
ARGUMENTS = "--swarm-size 2 --world hall_12 --speed 4 --viewer --port 0 --no-report"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Yield where the viewer of a running swarm is."""
    folder = tmp_path_factory.mktemp("live")
    log = folder / "up.log"
    with reserved_domain() as domain, log.open("w") as output:
        process = subprocess.Popen(
            [sys.executable, "-c", UP, *ARGUMENTS.split(), "--run-dir", str(folder / "run")],
            env=os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)},
            cwd=folder,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
        try:
            yield _address(process, log)
        finally:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(40.0)
            process.kill()
    assert process.returncode == 0, log.read_text(encoding="utf-8")


def _address(process: "subprocess.Popen[bytes]", log: Path) -> str:
    end = time.monotonic() + 120.0
    while time.monotonic() < end:
        text = log.read_text(encoding="utf-8")
        found = re.search(r"viewer: (http://\S+/)", text)
        if found and "active 2/2" in text:
            return found[1]
        assert process.poll() is None, text
        time.sleep(0.3)
    raise AssertionError(log.read_text(encoding="utf-8"))


def test_a_robot_goes_where_the_floor_is_clicked(browser: WebDriver, address: str) -> None:
    browser.get(f"{address}?robot=Srobot1")
    wait_for(lambda: "2, 2 answering" in text_of(browser), "two robots")
    wait_for(lambda: "page of its own" in text_of(browser), "the robot of the address")
    wait_for(lambda: "Pause" in text_of(browser), "the simulation's buttons")
    time.sleep(2.0)  # the camera comes to the robot
    press(browser, "Goal")
    wait_for(lambda: "click the floor" in text_of(browser), "the tool")
    click_canvas(browser, -70, -60)
    wait_for(lambda: "Goal sent" in text_of(browser), "the goal to be sent")
    wait_for(lambda: "1 reached, 0 failed" in text_of(browser), "the robot to arrive")
    assert errors(browser) == []


def test_time_stands_still_and_goes_on(browser: WebDriver, address: str) -> None:
    browser.get(address)
    press(browser, "Pause")
    wait_for(lambda: "(paused)" in text_of(browser), "the pause")
    before = _time(browser)
    press(browser, "Step 0.1 s")
    wait_for(lambda: _time(browser) == pytest.approx(before + 0.1), "one step")
    press(browser, "Resume")
    wait_for(lambda: _time(browser) > before + 1.0, "time to go on")
    assert errors(browser) == []


def _time(browser: WebDriver) -> float:
    found = re.search(r"simulated time\s+([\d.]+) s", text_of(browser))
    assert found is not None
    return float(found[1])
