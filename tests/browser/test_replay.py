"""A recording in the viewer, in a real browser: played, at several speeds, and wound."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from swarm_common.middleware.topic_table import WORLD_TOPICS, robot_topic
from swarm_recording.selection import ALWAYS
from swarm_recording.tape import Tape
from swarm_view.state import topics
from tests.browser.page import (
    choose,
    click_time_line,
    errors,
    open_page,
    open_tab,
    press,
    see,
    text_of,
    wait_for,
)
from tests.fakes.moving_feed import PERIOD, MovingFeed

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]
ROOT = Path(__file__).resolve().parents[2]
REPLAY = "from swarm_commander.cli.main import replay; replay()"
KINDS = ("status", "scan", "robot_description")
LENGTH = 400.0  # [s] of the recording
COLLISION = 100.0  # [s] at which two robots collide in it


def record(path):
    """Write a recording of four robots, of which one goes and another one comes half-way."""
    now = [0.0]
    feed = MovingFeed(4, clock=lambda: now[0])
    feed.collides_at = round(COLLISION / PERIOD)
    tape = Tape(path, {"world": "slim_blockage"})
    known: set[str] = set()
    while now[0] < LENGTH:
        if now[0] > 0.5 * LENGTH and "Srobot9" not in feed.names:
            feed.let_be(["Srobot1", "Srobot2", "Srobot4", "Srobot9"])
        feed.want({*ALWAYS, *(f"/{n}/{kind}" for n in feed.names for kind in KINDS)})
        for name, data in feed.take():
            if name not in known:
                tape.add_topic(_topic(name))
                known.add(name)
            tape.write(name, round(now[0] * 1e9), data)
        now[0] += PERIOD
    tape.close()


def _topic(name):
    world = {topic.name: topic for topic in WORLD_TOPICS}
    return world[name] if name in world else robot_topic(*topics.split(name))


@pytest.fixture(scope="module")
def address(browser, tmp_path_factory):
    """Yield where a recording is shown."""
    folder = tmp_path_factory.mktemp("replay")
    record(folder / "recording.mcap")
    log = folder / "replay.log"
    with log.open("w") as output:
        process = subprocess.Popen(
            [sys.executable, "-c", REPLAY, str(folder / "recording.mcap"), "--port", "0"],
            env=os.environ | {"PYTHONPATH": str(ROOT)}, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            end = time.monotonic() + 120.0
            while (found := re.search(r"viewer: (http://\S+)", log.read_text())) is None:
                assert process.poll() is None, log.read_text()
                assert time.monotonic() < end, log.read_text()
                time.sleep(0.3)
            yield found[1]
            browser.get("about:blank")
        finally:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(30.0)
            process.kill()
    assert process.returncode == 0, log.read_text()


def time_shown(browser):
    open_tab(browser, "Run")
    found = re.search(r"simulated time\s+([\d.]+) s", text_of(browser))
    assert found is not None, text_of(browser)
    return float(found[1])


def test_a_recording_is_played_at_several_speeds(browser, address):
    open_page(browser, f"{address}&robot=Srobot3")
    see(browser, "estimate", "the robot of the address")
    assert "Cancel goal" not in text_of(browser)
    assert "Remove robot" not in text_of(browser)
    if "Pause" in text_of(browser):
        press(browser, "Pause")
    for speed, least in (("1 x", 0.5), ("5 x", 3.0), ("20 x", 12.0)):
        choose(browser, "Speed", speed)
        press(browser, "Play")
        see(browser, "Pause", "the recording to be played")
        before, started = time_shown(browser), time.monotonic()
        time.sleep(5.0)
        passed = (time_shown(browser) - before) / (time.monotonic() - started)
        assert passed > least, f"{passed:.1f} times real time at {speed}"
        press(browser, "Pause")
        see(browser, "Play\n", "the recording to be held")
    choose(browser, "Speed", "20 x")
    press(browser, "Play")
    wait_for(lambda: time_shown(browser) > 0.6 * LENGTH, "the second half")
    see(browser, "Srobot3 is not there any more", "a robot to be gone")
    browser.execute_script("window.swarm.send('select', 'Srobot9')")  # as a click on its name does
    see(browser, "page of its own", "the robot that came")
    wait_for(lambda: time_shown(browser) > LENGTH - 1.0, "the end")
    assert errors(browser) == []


def test_the_time_line_leads_to_what_happened(browser, address):
    open_page(browser, address)
    see(browser, "collisions 1", "the mark of the collision")
    text = text_of(browser)
    assert "goals 0" in text
    assert "of this machine's" not in text  # the watcher's machine is not the run's
    if "Pause" in text:
        press(browser, "Pause")
    click_time_line(browser, 0.05)
    wait_for(lambda: 10.0 < time_shown(browser) < 30.0, "the beginning")
    press(browser, "▸|")
    wait_for(lambda: time_shown(browser) == pytest.approx(COLLISION), "the collision")
    see(browser, "robot touches robot; nearest to each other: Srobot")
    press(browser, "◂")
    wait_for(lambda: time_shown(browser) == pytest.approx(COLLISION - 0.1), "a step back")
    press(browser, "+1 s")
    wait_for(lambda: time_shown(browser) == pytest.approx(COLLISION + 0.9), "a second on")
    click_time_line(browser, 0.75)
    wait_for(lambda: 280.0 < time_shown(browser) < 320.0, "the last quarter")
    press(browser, "|◂")
    wait_for(lambda: time_shown(browser) < 0.55 * LENGTH, "the mark before, a wait")
    see(browser, "waits: ")
    assert errors(browser) == []
