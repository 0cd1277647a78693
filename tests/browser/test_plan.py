"""*Plan*, the past, keys and contrast in a real browser."""

import time
from pathlib import Path

import numpy as np
import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from swarm_view.page.plan import FROM
from tests.browser.page import errors, open_page, open_tab, see, text_of, wait_for
from tests.browser.test_page import Show, page_of

pytestmark = [pytest.mark.long, pytest.mark.timeout(400)]
FAINT = Path(__file__).with_name("contrast.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def many(browser):
    running = Show(FROM)
    yield running
    browser.get("about:blank")
    running.close()


def test_many_robots_are_shown_from_above(browser, many):
    open_page(browser, many.server.url())
    wait_for(
        lambda: bool(
            browser.execute_script("return swarm.plan.sizes?.length === arguments[0]", FROM)
        ),
        "all robots on the plan",
    )
    overlapping = browser.execute_script(
        "const spots = swarm.plan.spots(), sizes = swarm.plan.sizes, own = 0.3 * swarm.plan.scale;"
        "return spots.some(([x, y], i) => spots.some(([a, b], j) => i < j && sizes[i] > own"
        " && Math.hypot(a - x, b - y) < sizes[i] + sizes[j] - 1));"
    )
    assert overlapping is False
    x, y = browser.execute_script("return swarm.plan.spots()[6]")
    canvas = browser.find_element("id", "swarm-plan")
    size = canvas.size
    middle = round(x - size["width"] / 2), round(y - size["height"] / 2)
    ActionChains(browser).move_to_element_with_offset(canvas, *middle).click().perform()
    wait_for(lambda: page_of(many).robot == "Srobot7", "the robot that was clicked")
    assert errors(browser) == []


def test_robots_glide_to_where_they_are_said_to_be(browser, many):
    open_page(browser, many.server.url())
    wait_for(
        lambda: bool(
            browser.execute_script("return swarm.plan.sizes?.length === arguments[0]", FROM)
        ),
        "all robots on the plan",
    )
    half, end = browser.execute_script(
        "const { plan } = swarm;"
        "plan.poses = plan.goal = plan.goal.map(() => 0);"
        "plan.move(plan.goal.map((_, at) => (at % 3 ? 0 : 600)));"
        "plan.period = 10000; plan.since = performance.now() - 5000; plan.glide();"
        "const half = plan.poses[0]; plan.since -= 5000; plan.glide();"
        "return [half, plan.poses[0]];"
    )
    assert half == pytest.approx(300, abs=30)
    assert end == 600


def test_a_station_is_moved_for_the_next_run(browser, many):
    open_page(browser, many.server.url())
    see(browser, "answering")
    page = page_of(many)
    name = next(iter(many.viewer._swarm.stations))
    page._post(lambda: page._carry(name, np.zeros(2), np.array([1.0, 2.0])))
    see(browser, f"{name}: [1.00, 2.00, …]", "the line for sites.yaml")


def test_the_past_has_a_frame_that_does_not_flicker(browser, many):
    open_page(browser, many.server.url())
    page = page_of(many)
    opened = page.shown_time
    wait_for(lambda: page.history.end > opened + 4.0, "four seconds")
    ActionChains(browser).send_keys(Keys.ARROW_LEFT).perform()
    wait_for(lambda: bool(browser.find_elements("id", "swarm-past")), "the frame of the past")
    samples = []
    for _ in range(40):
        samples.append(
            browser.execute_script(
                "return [!!document.getElementById('swarm-past'),"
                " document.querySelector('[data-swarm-clock]')?.textContent ?? '']"
            )
        )
        time.sleep(0.1)
    assert all(is_framed and "the past" in clock for is_framed, clock in samples)
    ActionChains(browser).send_keys(Keys.ESCAPE).perform()
    wait_for(lambda: not browser.find_elements("id", "swarm-past"), "the present")


def test_keys_have_a_sheet_and_nothing_of_viser_leaks_in(browser, many):
    open_page(browser, many.server.url())
    see(browser, "answering")
    ActionChains(browser).send_keys("?").perform()
    wait_for(lambda: "follow the chosen robot" in text_of(browser), "the sheet")
    ActionChains(browser).send_keys(Keys.ESCAPE).perform()
    wait_for(lambda: "follow the chosen robot" not in text_of(browser), "the sheet to go")
    for leak in ("Show Viser Logo", "Software WebGL"):
        assert leak not in text_of(browser)
    for tab in ("Run", "Robot", "View"):
        open_tab(browser, tab)
        script = "return document.querySelectorAll('button[data-swarm-primary]').length"
        assert browser.execute_script(script) <= 1, tab


@pytest.mark.parametrize("dark", ["", "&dark=1"])
def test_texts_stand_out_from_their_ground(browser, many, dark):
    open_page(browser, many.server.url() + dark)
    see(browser, "answering")
    for tab in ("Run", "Robot", "View"):
        open_tab(browser, tab)
        time.sleep(1.0)
        assert browser.execute_script(FAINT) == [], tab
