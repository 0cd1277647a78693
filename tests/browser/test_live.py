"""The viewer of a real swarm in a real browser: a click on the floor sends a robot there."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
from selenium.webdriver.common.action_chains import ActionChains

from tests.browser.page import (
    choose,
    chosen,
    click_canvas,
    drag_canvas,
    errors,
    labelled,
    open_page,
    press,
    reach,
    see,
    text_of,
    tick_box,
    unfold,
    wait_for,
)
from tests.fakes.ros_domains import reserved_domain

pytestmark = [pytest.mark.long, pytest.mark.timeout(900)]
ROOT = Path(__file__).resolve().parents[2]
UP = "from swarm_commander.cli.main import swarm_up; swarm_up()"
START_LIMIT = 480.0  # [s] of wall time; a first start compiles
VIEW = "from swarm_view.cli import main; main()"
ARGUMENTS = "--swarm-size 2 --world hall_12 --speed 2 --viewer --port 0 --no-report"


@dataclass(frozen=True)
class Swarm:
    """A running swarm: where its viewer is, and what its terminals need."""

    address: str
    folder: Path
    environment: dict[str, str]


@contextlib.contextmanager
def command(code, words, folder, environment, log, codes=(0,)):
    """Run one of our commands, end it as a user does, and look at its exit code."""
    with log.open("w") as output:
        process = subprocess.Popen(
            [sys.executable, "-c", code, *words.split()],
            env=environment, cwd=folder, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(60.0)
            process.kill()
    assert process.returncode in codes, log.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def swarm(browser, tmp_path_factory):
    """Yield a running swarm with a viewer."""
    folder = tmp_path_factory.mktemp("live")
    log = folder / "up.log"
    with reserved_domain() as domain:
        environment = os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)}
        words = f"{ARGUMENTS} --run-dir {folder / 'run'}"
        # 1, since a goal that a test cancels counts as missed
        with command(UP, words, folder, environment, log, codes=(0, 1)) as process:
            yield Swarm(_address(process, log, "active 2/2"), folder, environment)
            browser.get("about:blank")


@pytest.fixture
def address(swarm):
    return swarm.address


def _address(process, log, sign):
    end = time.monotonic() + START_LIMIT
    while time.monotonic() < end:
        text = log.read_text(encoding="utf-8")
        found = re.search(r"viewer: (http://\S+)", text)
        if found and sign in text:
            return found[1]
        assert process.poll() is None, text
        time.sleep(0.3)
    raise AssertionError(log.read_text(encoding="utf-8"))


def _open(browser, address, robot):
    open_page(browser, f"{address}&robot={robot}")
    see(browser, "answering", "the robots")
    see(browser, "estimate", "the robot of the address")
    see(browser, "Step 0.1 s", "the simulation's buttons")
    time.sleep(4.0)  # the camera comes to the robot


def _use(browser, tool):
    press(browser, tool)
    see(browser, "click the floor", f"the tool '{tool}'")


def _pause(browser):
    if "(paused)" not in text_of(browser):
        press(browser, "Pause")
    see(browser, "(paused)", "the pause")


def _step(browser, ticks):
    for _ in range(ticks):
        press(browser, "Step 0.1 s")
        time.sleep(0.5)


def _number(browser, pattern):
    reach(browser, lambda: re.search(pattern, text_of(browser)) is not None, pattern)
    found = re.search(pattern, text_of(browser))
    assert found is not None, text_of(browser)
    return float(found[1])


def _time(browser):
    return _number(browser, r"simulated time\s+([\d.]+) s")


def test_a_robot_goes_where_the_floor_is_clicked(browser, address):
    _open(browser, address, "Srobot1")
    _use(browser, "Goal")
    click_canvas(browser, -70, -60)
    see(browser, "Goal sent", "the goal to be sent")
    see(browser, "1 reached, 0 tries failed", "the robot to arrive")
    assert errors(browser) == []


def test_the_camera_has_followed(browser, address):
    choose(browser, "Robot", "(none)")
    wait_for(lambda: "estimate" not in text_of(browser), "no robot to be selected")

    def is_picked():
        click_canvas(browser, 0, -8)  # the robot that was followed is in the middle
        time.sleep(1.0)
        return chosen(browser, "Robot") == "Srobot1"

    wait_for(is_picked, "the robot to be picked")
    assert errors(browser) == []


def test_a_drag_gives_the_heading_and_a_goal_is_cancelled(browser, address):
    _open(browser, address, "Srobot2")
    _pause(browser)
    _use(browser, "Goal")
    drag_canvas(browser, (-100, -60), (-70, 40))
    see(browser, "Goal sent", "the goal to be sent")
    clicked = _number(browser, r"Goal sent: \(\S+, \S+, (\S+)\)")
    assert -3.1 < clicked < -1.6  # towards the reader and to the left
    _step(browser, 5)
    see(browser, "driving", "the robot to set off")
    press(browser, "Cancel goal")
    _step(browser, 5)  # robots answer in their ticks
    see(browser, "goal cancelled", "the cancellation")
    see(browser, "idle 2", "the robot to stand")
    press(browser, "Cancel goal")
    _step(browser, 2)
    see(browser, "no goal to cancel", "the answer that there is none")
    press(browser, "Resume")
    assert errors(browser) == []


def test_an_initial_pose_is_believed(browser, address):
    _open(browser, address, "Srobot2")
    offset = r"estimate\s+.*, ([\d.]+) m off"
    wait_for(lambda: _number(browser, offset) < 0.02, "an estimate that is right")
    _pause(browser)
    _use(browser, "Initial pose")
    click_canvas(browser, 0, -20)  # above the time line
    see(browser, "Initial pose sent", "the pose to be sent")
    _step(browser, 8)
    wait_for(lambda: _number(browser, offset) > 0.05, "another estimate")
    press(browser, "Resume")
    assert errors(browser) == []


def test_time_stands_still_and_goes_on(browser, address):
    open_page(browser, address)
    see(browser, "answering", "the robots")
    _pause(browser)
    before = _time(browser)
    press(browser, "Step 0.1 s")
    wait_for(lambda: _time(browser) == pytest.approx(before + 0.1), "one step")
    press(browser, "Resume")
    wait_for(lambda: _time(browser) > before + 1.0, "time to go on")
    assert errors(browser) == []


def test_the_speed_is_chosen(browser, address):
    open_page(browser, address)
    wait_for(lambda: chosen(browser, "Speed") == "2 x", "the speed of the command line")
    choose(browser, "Speed", "0.25 x")
    factor = r"real-time factor\s+([\d.]+)"
    wait_for(lambda: 0.0 < _number(browser, factor) < 0.3, "a slow world")
    choose(browser, "Speed", "2 x")
    wait_for(lambda: _number(browser, factor) > 0.4, "a fast world")
    assert errors(browser) == []


def test_robots_come_and_go(browser, address):
    open_page(browser, address)
    see(browser, "2, 2 answering", "two robots")
    press(browser, "Spawn at a free place")
    see(browser, "3, 3 answering", "a third robot")
    see(browser, "Srobot3 has come")
    press(browser, "Remove robot")
    see(browser, "Select a robot first", "the question which")
    unfold(browser, "New robots")
    choose(browser, "Model", "turtlebot3_burger")
    _use(browser, "Spawn by a click")
    click_canvas(browser, -60, -45)  # on the floor, above the time line
    see(browser, "4, 4 answering", "a fourth robot")
    for name in ("Srobot3", "Srobot4"):
        choose(browser, "Robot", name)
        see(browser, "estimate", "what the newcomer says")
        press(browser, "Remove robot")
        press(browser, "Cancel")  # it asks first
        wait_for(lambda: "counts as missed" not in text_of(browser), "the question to go")
        press(browser, "Remove robot")
        press(browser, f"Remove {name}")
        wait_for(lambda: chosen(browser, "Robot") == "(none)", f"{name} to be gone")
    see(browser, "2, 2 answering", "two robots again")
    assert errors(browser) == []


def test_a_robot_is_driven_by_hand(browser, address):
    _open(browser, address, "Srobot1")
    press(browser, "Drive by hand")
    see(browser, "Srobot1 is yours", "the robot to be handed over")

    def x():
        return _number(browser, r"estimate\s+\((-?[\d.]+), ")

    def y():
        return _number(browser, r"estimate\s+\(-?[\d.]+, (-?[\d.]+), ")

    before = x(), y()
    body = browser.find_element("css selector", "body")
    moved = 0.0
    for key in ("w", "s"):  # one of both ways is free
        ActionChains(browser).move_to_element(body).key_down(key).perform()
        time.sleep(4.0)
        ActionChains(browser).key_up(key).perform()
        time.sleep(1.5)
        moved = max(moved, abs(x() - before[0]), abs(y() - before[1]))
    assert moved > 0.1

    def rests():
        still = x(), y()
        time.sleep(2.0)
        return (x(), y()) == pytest.approx(still, abs=0.05)

    wait_for(rests, "the robot to stand: nobody presses a key")
    press(browser, "Give Srobot1 back")
    see(browser, "Srobot1 is on its own again", "the robot to be free")
    see(browser, "Drive by hand", "the button as before")
    assert errors(browser) == []


def test_all_layers_are_shown_and_hidden(browser, address):
    _open(browser, address, "Srobot1")
    labels = (
        "Local costmap",
        "Global costmap",
        "Footprint",
        "Particles",
        "Names and states",
        "Trails",
    )
    for label in labels:
        tick_box(browser, label)
    time.sleep(3.0)
    for label in labels:
        assert labelled(browser, label).is_selected()
        tick_box(browser, label)
    time.sleep(1.0)
    assert errors(browser) == []


def test_a_view_of_its_own_is_attached(browser, swarm):
    log = swarm.folder / "view.log"
    words = "--host 0.0.0.0 --port 0"
    with command(VIEW, words, swarm.folder, swarm.environment, log) as process:
        address = _address(process, log, "Ctrl-C")
        bare, _, query = address.partition("?")
        port = re.search(r":(\d+)/", bare)
        assert query.startswith("token=")
        open_page(browser, f"http://127.0.0.1:{port[1]}/")
        see(browser, "needs its token")
        open_page(browser, f"http://127.0.0.1:{port[1]}/?robot=Srobot1&{query}")
        see(browser, "2, 2 answering", "two robots")
        see(browser, "estimate", "the robot of the address")
        assert errors(browser) == []
        browser.get("about:blank")
