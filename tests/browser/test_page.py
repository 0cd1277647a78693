"""The viewer's page in a real browser, fed without a graph."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest
from selenium.webdriver.remote.webdriver import WebDriver

from swarm_view import topics
from swarm_view.server import Server
from swarm_view.topics import Layer
from swarm_view.viewer import Viewer
from tests.browser.page import errors, picture, text_of, wait_for
from tests.fakes.moving_feed import MovingFeed

pytestmark = [pytest.mark.long, pytest.mark.timeout(400)]
ROBOTS = 20


class Show:
    """A viewer of robots that move by themselves."""

    def __init__(self) -> None:
        self.feed = MovingFeed(ROBOTS, ("turtlebot3_waffle", "turtlebot3_burger"))
        self.server = Server("127.0.0.1", 0)
        self.viewer = Viewer(self.server, self.feed, None)
        self._thread = threading.Thread(target=self.viewer.run)
        self._thread.start()

    def close(self) -> None:
        self.viewer.stop()
        self._thread.join(20.0)
        self.viewer.close()


@pytest.fixture(scope="module")
def show() -> Iterator[Show]:
    running = Show()
    yield running
    running.close()


def test_twenty_robots_are_there_and_move(browser: WebDriver, show: Show) -> None:
    assert show.feed.wanted == set()
    show.feed.is_standing = False
    browser.get(show.server.url())
    wait_for(lambda: "20, 20 answering" in text_of(browser), "twenty robots in the panel")
    assert "190 reached, 0 missed" in text_of(browser)
    assert "driving 4" in text_of(browser)
    assert topics.TF in show.feed.wanted
    assert not any(topic.endswith("/scan") for topic in show.feed.wanted)
    show.feed.is_standing = True
    before = picture(browser)
    show.feed.is_standing = False
    wait_for(lambda: differing(before, picture(browser)) > 50, "robots that move")
    assert errors(browser) == []


def test_a_robot_has_a_page_of_its_own(browser: WebDriver, show: Show) -> None:
    show.feed.is_standing = False
    browser.get(show.server.url("Srobot3"))
    scan = topics.of_layer("Srobot3", Layer.SCAN)
    wait_for(lambda: scan in show.feed.wanted, "the robot's scan to be wanted")
    wait_for(lambda: "Srobot3" in text_of(browser), "the robot in the panel")
    wait_for(lambda: "loader_1, number 2 in the queue" in text_of(browser), "its station")
    assert [topic for topic in show.feed.wanted if topic.endswith("/scan")] == [scan]
    assert browser.title == "swarm · Srobot3"
    assert errors(browser) == []


def test_nobody_looks(browser: WebDriver, show: Show) -> None:
    browser.get("about:blank")
    wait_for(lambda: show.feed.wanted == set(), "the viewer to want nothing")
    assert show.viewer.pages == 0


def differing(before: np.ndarray, after: np.ndarray) -> int:
    """Return the number of pixels that differ visibly, without the panel on the right."""
    half = before.shape[1] // 2
    change = np.abs(before[:, :half].astype(int) - after[:, :half]).max(axis=2)
    return int((change > 40).sum())
