"""The viewer's page in a real browser, fed without a graph."""

import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains

from swarm_common.model.palette import state_color
from swarm_common.process.messages import KernelsCompiled
from swarm_view.scene.images import LIGHT
from swarm_view.scene.shapes import lifted
from swarm_view.scene.views import PANEL_WIDTH, STRIP_HEIGHT
from swarm_view.server.server import Server
from swarm_view.state import topics
from swarm_view.state.topics import Layer
from swarm_view.viewer import Viewer
from tests.browser.page import (
    click_canvas,
    click_time_line,
    errors,
    open_page,
    open_tab,
    picture,
    press,
    resize,
    see,
    text_of,
    tick_box,
    unfold,
    wait_for,
)
from tests.fakes.moving_feed import MovingFeed

pytestmark = [pytest.mark.long, pytest.mark.timeout(400)]
ROBOTS = 20


class Show:
    """A viewer of robots that move by themselves."""

    def __init__(self, count=ROBOTS):
        self.feed = MovingFeed(count, ("turtlebot3_waffle", "turtlebot3_burger"))
        self.server = Server("127.0.0.1", 0)
        self.viewer = Viewer(self.server, self.feed, None)
        self._thread = threading.Thread(target=self.viewer.run)
        self._thread.start()

    def close(self):
        self.viewer.stop()
        self._thread.join(20.0)
        self.viewer.close()


@pytest.fixture(scope="module")
def show(browser):
    running = Show()
    yield running
    browser.get("about:blank")
    running.close()


def test_twenty_robots_are_there_and_move(browser, show):
    assert show.feed.wanted == set()
    show.feed.is_standing = False
    open_page(browser, show.server.url())
    see(browser, "20, 20 answering", "twenty robots in the panel")
    see(browser, "190 reached, 0 tries failed", "all goals")
    see(browser, "driving 4", "all states")
    assert topics.TF in show.feed.wanted
    assert not any(topic.endswith("/scan") for topic in show.feed.wanted)
    show.feed.is_standing = True
    before = picture(browser)
    show.feed.is_standing = False
    wait_for(lambda: differing(before, picture(browser)) > 50, "robots that move")
    assert errors(browser) == []


def test_a_robot_has_a_page_of_its_own(browser, show):
    show.feed.is_standing = False
    open_page(browser, show.server.url("Srobot3"))
    scan = topics.of_layer("Srobot3", Layer.SCAN)
    wait_for(lambda: scan in show.feed.wanted, "the robot's scan to be wanted")
    see(browser, "Srobot3", "the robot in the panel")
    see(browser, "loader_1, number 2 in the queue", "its station")
    assert [topic for topic in show.feed.wanted if topic.endswith("/scan")] == [scan]
    assert browser.title == "swarm · Srobot3"
    assert errors(browser) == []


@pytest.fixture
def overview(browser):
    before = browser.get_window_size()
    resize(browser, 1600, 900)
    yield
    browser.set_window_size(before["width"], before["height"])


def page_of(show):
    wait_for(lambda: len(show.viewer._pages) == 1, "one page")
    return next(iter(show.viewer._pages.values()))


def sight_of(show):
    return page_of(show)._view


def seen_from(show, browser, view):
    """Choose a preset and return the camera when it has come to rest."""
    sight = sight_of(show)
    wait_for(lambda: sight.camera is not None, "the page to report")
    before = sight.camera
    assert before is not None
    open_tab(browser, "View")
    press(browser, view)
    seen = [before]

    def rests():
        time.sleep(0.7)
        camera = sight.camera
        seen[:] = [camera]
        if view == "Robot's eye":
            return bool(camera.position[2] < 0.5)
        if view == "Follow":
            return bool(camera.position[2] < 5.0 and 1.0 < camera.position[2])
        wanted = sight._fitted
        return wanted is not None and bool(np.abs(wanted.position - camera.position).max() < 0.1)

    wait_for(rests, f"the view '{view}'")
    return seen[0]


@pytest.mark.usefixtures("overview")
def test_twenty_robots_are_seen_from_afar(browser, show):
    show.feed.is_standing = False
    open_page(browser, show.server.url())
    see(browser, "20, 20 answering", "twenty robots in the panel")
    see(browser, "stands on its way: a robot or an obstacle is in front of it")
    show.feed.is_standing = True
    for view in ("Top", "Hall"):
        camera = seen_from(show, browser, view)
        assert camera.width == pytest.approx(1600, abs=4)
        assert camera.height == pytest.approx(900, abs=4)
        image = still_picture(browser).astype(int)
        scale = image.shape[1] / camera.width
        poses = show.viewer._swarm.track.latest
        middles = lifted(show.viewer._fleet.middles(poses), 0.012)
        pixels, _ = camera.project(middles)
        heading = lifted(np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])]), 0.0)
        ahead, _ = camera.project(middles + 0.1 * heading)
        floor = np.array(LIGHT.free)
        for name, pixel, nose in zip(show.feed.names, pixels, ahead - pixels, strict=True):
            state = show.viewer._swarm.states[name].state
            across = np.array([-nose[1], nose[0]]) / np.linalg.norm(nose)
            squeeze = 1.0 if view == "Top" else 0.6  # a disc is seen from the side
            for side in (-11.0, 11.0):  # [px] of at least 24
                x, y = np.round(scale * (pixel + squeeze * side * across)).astype(int)
                assert np.abs(image[y, x] - floor).max() > 30, (view, name, "is too small")
            patch = patch_at(image, camera, pixel)
            hue = np.array(state_color(state))
            assert np.abs(patch - hue).sum(axis=1).min() < 130, (view, name, state)
    assert errors(browser) == []


def test_presets_walls_and_darkness(browser, show):
    show.feed.is_standing = False
    open_page(browser, show.server.url("Srobot5"))
    see(browser, "loader_1, number 4 in the queue", "its station")
    camera = seen_from(show, browser, "Top")
    assert camera.position[2] > 8.0
    assert np.hypot(*(camera.position - camera.target)[:2]) < 0.1
    light = picture(browser)
    tick_box(browser, "Whole walls")
    wait_for(lambda: differing(light, picture(browser)) > 100, "whole walls")
    tick_box(browser, "Whole walls")
    tick_box(browser, "Dark")
    wait_for(lambda: is_dark(browser), "darkness")
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


@pytest.mark.usefixtures("overview")
def test_a_page_looks_into_the_past_of_a_live_swarm(browser, show):
    show.feed.is_standing = False
    open_page(browser, show.server.url("Srobot5"))
    see(browser, "loader_1, number 4 in the queue", "its station")
    page = page_of(show)
    seen_from(show, browser, "Top")
    opened = page.shown_time  # before it was opened there is a gap: no page was open
    wait_for(lambda: page.history.end > opened + 12.0, "twelve seconds")
    start, end = page.history.span
    click_time_line(browser, (opened + 6.0 - start) / (end - start))
    see(browser, "· the past", "the past")
    time_then = page.shown_time
    assert time_then == pytest.approx(opened + 6.0, abs=3.0)  # the line grows
    then = still_picture(browser)
    moment = page.history.moment(time_then)
    tick = moment[0]
    np.testing.assert_allclose(moment[2][:, :2], show.feed.poses(tick)[:, :2], atol=1e-4)
    time.sleep(1.5)
    here = page._past.swarm.track.latest  # others drive on, this page stands
    np.testing.assert_allclose(here[:, :2], moment[2][:, :2], atol=1e-4)
    middles = page._past.fleet.middles(here)
    gaps = np.hypot(*(middles - show.viewer._fleet.middles(show.viewer._swarm.track.latest)).T)
    camera = sight_of(show).camera
    pixels, _ = camera.project(lifted(middles, 0.012))
    image = picture(browser).astype(int)
    is_seen = [
        np.abs(patch_at(image, camera, pixel) - state_color(state.state)).sum(axis=1).min() < 130
        for pixel, state in zip(pixels, page._past.swarm.states.values(), strict=True)
        if pixel[0] < camera.width - 1.1 * PANEL_WIDTH  # panel and time line lie on the others
        and pixel[1] < camera.height - 1.3 * STRIP_HEIGHT
    ]
    assert gaps.max() > 0.1
    assert len(is_seen) > 3
    assert sum(is_seen) > 0.8 * len(is_seen)
    press(browser, "+1 s")
    wait_for(lambda: differing(then, picture(browser)) > 50, "a second later")
    assert page.shown_time == pytest.approx(time_then + 1.0, abs=0.06)
    press(browser, "Live")
    wait_for(lambda: "· the past" not in text_of(browser), "the present")
    before = picture(browser)
    wait_for(lambda: differing(before, picture(browser)) > 50, "robots that move")
    assert errors(browser) == []


def test_a_robot_tells_what_it_did_and_its_topics(browser, show):
    show.feed.is_standing = False
    open_page(browser, show.server.url("Srobot3"))
    see(browser, "waiting for", "how long it has waited")
    see(browser, "stands on its way: a robot or an obstacle is in front of it")
    unfold(browser, "History")
    see(browser, "waiting loader_1", "its history")
    unfold(browser, "Topics")
    see(browser, "/Srobot3/cmd_vel", "its topics")
    browser.execute_script(
        "document.querySelector(arguments[0]).click()", "[data-swarm-copy='/Srobot3/cmd_vel']"
    )
    see(browser, "Copied: /Srobot3/cmd_vel", "the copy")
    plans = {topics.of_layer(name, Layer.PLAN) for name in show.feed.names}
    open_tab(browser, "View")
    tick_box(browser, "Plans of up to 20 robots")
    wait_for(lambda: plans <= show.feed.wanted, "everybody's plan to be wanted")
    for title in ("Throughput", "States", "Clearance"):
        tab = browser.find_element("xpath", f"//*[normalize-space(text())='{title}']")
        ActionChains(browser).click(tab).perform()
        wait_for(lambda: bool(browser.find_elements("css selector", ".uplot canvas")), title)
    assert errors(browser) == []


def test_measuring_pictures_films_and_links(browser, show, tmp_path):
    browser.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
    )
    show.feed.is_standing = False
    open_page(browser, show.server.url("Srobot3"))
    see(browser, "loader_1, number 2 in the queue", "its station")
    camera = seen_from(show, browser, "Top")
    press(browser, "Measure")
    see(browser, "Measure: click", "the ruler")
    width, height = camera.width, camera.height
    places = np.array([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    pixels, _ = camera.project(places)
    for right, down in np.round(pixels - (0.5 * width, 0.5 * height)).astype(int):
        time.sleep(1.0)
        click_canvas(browser, int(right), int(down))
        time.sleep(1.0)
    see(browser, "Measured: ", "the distance")
    found = re.search(r"Measured: ([\d.]+) m", text_of(browser))
    assert float(found[1]) == pytest.approx(4.0, abs=0.1)
    press(browser, "Save picture")
    wait_for(lambda: bool(list(tmp_path.glob("swarm_*s.png"))), "the picture")
    time.sleep(1.0)
    (saved,) = tmp_path.glob("swarm_*s.png")
    assert np.asarray(Image.open(saved).convert("RGB")).std() > 10.0
    press(browser, "Record film")
    see(browser, "Stop and save film", "the film to begin")
    time.sleep(4.0)
    assert browser.execute_script("return swarm.figures.length > 5 && swarm.legend.length > 3")
    press(browser, "Stop and save film")
    see(browser, "Saved a film", "the film")
    films: list[Path] = []

    def is_there():
        films[:] = [*tmp_path.glob("swarm_*s.webm"), *tmp_path.glob("swarm_*s.mp4")]
        return bool(films) and films[0].stat().st_size > 1000

    wait_for(is_there, "the film's file")
    film = films[0]
    assert film.read_bytes()[4:8] == b"ftyp" or b"\x44\x89\x88" in film.read_bytes()[:400]
    click_time_line(browser, 0.5)
    see(browser, "· the past", "the past")
    tick_box(browser, "Dark")
    shown = page_of(show).shown_time
    press(browser, "Copy link")
    see(browser, "Copied: http://", "the link")
    copied = re.search(r"Copied: (http\S+)", text_of(browser))
    assert errors(browser) == []
    open_page(browser, copied[1])
    see(browser, "· the past", "the time of the link")
    page = page_of(show)
    assert page.robot == "Srobot3"
    assert page.shown_time == pytest.approx(shown, abs=0.11)
    wait_for(lambda: is_dark(browser), "darkness")
    then = sight_of(show).camera
    np.testing.assert_allclose(then.position, camera.position, atol=0.1)
    assert errors(browser) == []


def is_dark(browser):
    return bool(picture(browser)[5:60, 5:60].mean() < 110.0)  # light ones are above 190


def test_nobody_looks(browser, show):
    open_page(browser, show.server.url("Srobot3"))
    page_of(show)
    browser.get("about:blank")
    wait_for(lambda: show.feed.wanted == set(), "the viewer to want nothing", limit=10.0)
    assert len(show.viewer._pages) == 0
    browser.back()
    see(browser, "loader_1, number 2 in the queue", "the page again")
    assert errors(browser) == []


def patch_at(image, camera, pixel):
    x, y = np.round(pixel * image.shape[1] / camera.width).astype(int)
    return image[max(0, y - 3) : y + 4, max(0, x - 3) : x + 4].reshape(-1, 3)


def still_picture(browser):
    """Return what the page looks like once it does not change any more: all is drawn."""
    seen = [picture(browser)]

    def rests():
        time.sleep(1.0)  # marks get another size up to 0.25 s after the camera has moved
        seen.append(picture(browser))
        return differing(seen[-2], seen[-1]) == 0

    wait_for(rests, "a picture that does not change")
    return seen[-1]


def differing(before, after):
    high, half = int(0.65 * before.shape[0]), before.shape[1] // 2
    change = np.abs(before[:high, :half].astype(int) - after[:high, :half]).max(axis=2)
    return int((change > 40).sum())


def test_a_page_says_that_its_run_has_ended_and_that_one_starts(browser):
    feed, server = MovingFeed(2), Server("127.0.0.1", 0)
    feed.is_standing = True
    viewer = Viewer(server, feed, None, hear=lambda: [KernelsCompiled(35, 118)])
    thread = threading.Thread(target=viewer.run)
    thread.start()
    try:
        open_page(browser, server.url())
        see(browser, "35 of 118 kernels", "how far the start is")
        viewer.stop()
        see(browser, "The run has ended", "the end")
    finally:
        viewer.stop()
        thread.join(20.0)
        viewer.close()
        browser.get("about:blank")
