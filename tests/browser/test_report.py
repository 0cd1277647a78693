"""The page of a run in a browser: plots that answer, dark and light, tables that sort."""

import base64
import re
from pathlib import Path

import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from swarm_report.document import DRAWINGS, write_document
from tests.browser.page import errors, open_page, wait_for
from tests.fakes.run_folder import make_run

pytestmark = pytest.mark.long
FAINT = Path(__file__).with_name("contrast.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    folder = make_run(tmp_path_factory.mktemp("run"), robots=3, seconds=60, crash=True)
    open_page(browser, write_document(folder).as_uri())
    return browser


def _show(page, name):
    page.execute_script(f"document.getElementById('{name}').scrollIntoView({{block: 'center'}})")


def test_every_plot_is_drawn_without_a_complaint(page):
    for name in DRAWINGS:
        _show(page, name)
        wait_for(lambda n=name: page.find_elements(By.CSS_SELECTOR, f"#{n} .live .main-svg"), name)
    assert errors(page) == []


def test_a_plot_answers_to_the_mouse(page):
    _show(page, "throughput")
    wait_for(lambda: page.find_elements(By.CSS_SELECTOR, "#throughput .nsewdrag"), "the plot")
    area = page.find_element(By.CSS_SELECTOR, "#throughput .nsewdrag")

    def says():
        ActionChains(page).move_to_element_with_offset(area, 1, 1).move_to_element(area).perform()
        found = page.find_elements(By.CSS_SELECTOR, "#throughput .hoverlayer text")
        return any("per minute" in one.text for one in found)

    wait_for(says, "what is under the mouse")


def test_dark_and_light(page):
    def colors():
        script = (
            "return [getComputedStyle(document.body).backgroundColor,"
            " document.querySelector('#goals .ytitle').style.fill]"
        )
        _show(page, "goals")
        return tuple(page.execute_script(script))

    wait_for(lambda: page.find_elements(By.CSS_SELECTOR, "#goals .ytitle"), "the plot")
    before = colors()
    page.execute_script("document.getElementById('theme').click()")
    wait_for(lambda: all(a != b for a, b in zip(before, colors(), strict=True)), "the other theme")


def test_most_of_a_heat_map_stands_out_from_the_paper(page):
    _show(page, "density")
    wait_for(lambda: page.find_elements(By.CSS_SELECTOR, "#density .main-svg"), "the map")
    script = (
        "const { data } = document.querySelector('#density .live');"
        "const trace = data.find((one) => one.type === 'heatmap');"
        "return [trace.reversescale, document.documentElement.dataset.theme === 'dark']"
    )
    for _ in range(2):
        is_reversed, is_dark = page.execute_script(script)
        assert is_reversed == is_dark
        page.execute_script("document.getElementById('theme').click()")
        wait_for(lambda d=is_dark: page.execute_script(script) == [not d] * 2, "the other theme")


def test_on_paper_the_still_plots_are_used_on_white(page):
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        script = (
            "const of = (s) => getComputedStyle(document.querySelector(s));"
            "return [of('#goals img').display, of('#goals .live').display,"
            " of('body').backgroundColor]"
        )
        assert page.execute_script(script) == ["block", "none", "rgb(255, 255, 255)"]
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_a_click_on_a_heading_sorts(page):
    script = (
        "const table = document.querySelector('#trajectories table');"
        "const head = table.querySelectorAll('th')[3];"
        "head.click(); head.click();"
        "return [...table.tBodies[0].rows].map((row) => Number(row.cells[3].textContent))"
    )
    distances = page.execute_script(script)
    assert distances == sorted(distances, reverse=True)


def test_texts_stand_out_in_both_modes(page):
    for _ in range(2):
        assert page.execute_script(FAINT) == []
        page.execute_script("document.getElementById('theme').click()")


@pytest.mark.parametrize(("width", "height"), [(1024, 600), (390, 844)])
def test_it_fits_a_small_screen(page, width, height):
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    try:
        script = "return document.documentElement.scrollWidth <= innerWidth"
        wait_for(lambda: bool(page.execute_script(script)), "nothing beside the screen")
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_twenty_robots_print_on_four_pages(browser, tmp_path):
    folder = make_run(tmp_path, robots=20, seconds=60, crash=True)
    open_page(browser, write_document(folder).as_uri())
    paper = base64.b64decode(browser.print_page())
    assert 1 <= len(re.findall(rb"/Type\s*/Page\b", paper)) <= 4
