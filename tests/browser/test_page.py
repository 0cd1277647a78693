"""The viewer's page in a real browser, fed without a graph."""

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
from selenium.webdriver.remote.webdriver import WebDriver

from swarm_common.model.palette import state_color
from swarm_view import topics
from swarm_view.images import LIGHT
from swarm_view.server import Server
from swarm_view.shapes import lifted
from swarm_view.sight import Sight
from swarm_view.topics import Layer
from swarm_view.viewer import Viewer
from swarm_view.views import Camera
from tests.browser.page import errors, picture, press, text_of, tick_box, wait_for
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
    assert "190 reached, 0 tries failed" in text_of(browser)
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


@pytest.fixture
def overview(browser: WebDriver) -> Iterator[None]:
    """Let the page be 1600 x 900 pixels large."""
    before = browser.get_window_size()
    for _ in range(4):
        window = browser.get_window_size()
        inner = browser.execute_script("return [innerWidth, innerHeight]")
        share = 0.5 if inner[0] > 1.2 * window["width"] else 1.0
        browser.set_window_size(
            round(window["width"] + share * (1600 - inner[0])),
            round(window["height"] + share * (900 - inner[1])),
        )
    yield
    browser.set_window_size(before["width"], before["height"])


def sight_of(show: Show) -> Sight:
    return next(iter(show.viewer._pages.values()))._sight


def seen_from(show: Show, browser: WebDriver, view: str) -> Camera:
    """Choose a preset and return the camera when it has come to rest."""
    before = sight_of(show).camera
    assert before is not None
    press(browser, view)
    seen = [before, before]

    def rests() -> bool:
        time.sleep(1.0)
        camera = sight_of(show).camera
        assert camera is not None
        seen[:] = [seen[1], camera]
        gap = np.abs(seen[0].position - seen[1].position).max()
        return bool(gap < 0.3 and np.abs(before.position - camera.position).max() > 0.1)

    wait_for(rests, f"the view '{view}'")
    return seen[1]


@pytest.mark.usefixtures("overview")
def test_twenty_robots_are_seen_from_afar(browser: WebDriver, show: Show) -> None:
    show.feed.is_standing = False
    browser.get(show.server.url())
    wait_for(lambda: "20, 20 answering" in text_of(browser), "twenty robots in the panel")
    assert "stands on its way: a robot or an obstacle is in front of it" in text_of(browser)
    show.feed.is_standing = True
    for view in ("Top", "Hall"):
        camera = seen_from(show, browser, view)
        assert camera.width == pytest.approx(1600, abs=4)
        assert camera.height == pytest.approx(900, abs=4)
        image = picture(browser).astype(int)
        scale = image.shape[1] / camera.width
        poses = show.viewer._swarm.track.latest
        middles = lifted(show.viewer._fleet.middles(poses), 0.012)
        pixels, _ = camera.project(middles)
        ahead, _ = camera.project(
            middles
            + 0.1 * np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2]), 0 * poses[:, 2]])
        )
        floor = np.array(LIGHT.free)
        for name, pixel, nose in zip(show.feed.names, pixels, ahead - pixels, strict=True):
            state = show.viewer._swarm.states[name].state
            across = np.array([-nose[1], nose[0]]) / np.linalg.norm(nose)
            squeeze = 1.0 if view == "Top" else 0.6  # a disc is seen from the side
            for side in (-11.0, 11.0):  # [px] of at least 24
                x, y = np.round(scale * (pixel + squeeze * side * across)).astype(int)
                assert np.abs(image[y, x] - floor).max() > 30, (view, name, "is too small")
            x, y = np.round(scale * pixel).astype(int)
            patch = image[y - 3 : y + 4, x - 3 : x + 4].reshape(-1, 3)
            hue = np.array(state_color(state))
            assert np.abs(patch - hue).sum(axis=1).min() < 130, (view, name, state)
    assert errors(browser) == []


def test_presets_walls_and_darkness(browser: WebDriver, show: Show) -> None:
    show.feed.is_standing = False
    browser.get(show.server.url("Srobot5"))
    wait_for(lambda: "loader_1, number 4 in the queue" in text_of(browser), "its station")
    camera = seen_from(show, browser, "Top")
    assert camera.position[2] > 8.0
    assert np.hypot(*(camera.position - camera.target)[:2]) < 0.1
    light = picture(browser)
    tick_box(browser, "Whole walls")
    wait_for(lambda: differing(light, picture(browser)) > 100, "whole walls")
    tick_box(browser, "Whole walls")
    tick_box(browser, "Dark")
    wait_for(lambda: picture(browser)[5:60, 5:60].mean() < 60, "darkness")
    eye = seen_from(show, browser, "Robot's eye")
    index = show.feed.names.index("Srobot5")
    poses = show.viewer._swarm.track.latest
    assert np.hypot(*(eye.position[:2] - poses[index, :2])) < 1.2
    assert eye.position[2] < 0.5
    tick_box(browser, "Dark")
    followed = seen_from(show, browser, "Follow")
    poses = show.viewer._swarm.track.latest
    assert np.hypot(*(followed.target[:2] - poses[index, :2])) < 1.0
    assert followed.position[2] > 1.0
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
