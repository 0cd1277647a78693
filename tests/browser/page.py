"""What a person sees and does on a page of the viewer."""

import io
import itertools
import time
from collections.abc import Callable

import numpy as np
from PIL import Image
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.remote.webdriver import WebDriver
from selenium.webdriver.remote.webelement import WebElement

TABS = ("Run", "Robot", "View")  # of the panel
LIMIT = 150.0  # [s] of wall time for anything to show; software rendering on a busy machine


def wait_for(condition: Callable[[], bool], what: str, limit: float = LIMIT) -> None:
    """Wait until something holds; a browser that is busy is asked again."""
    end = time.monotonic() + limit
    while True:
        try:
            if condition():
                return
        except WebDriverException:
            pass
        assert time.monotonic() < end, f"waited in vain for: {what}"
        time.sleep(0.3)


def open_page(browser: WebDriver, address: str) -> None:
    browser.get("about:blank")
    errors(browser)
    browser.get(address)


def resize(browser: WebDriver, width: int, height: int) -> None:
    """Let the page have a size [px], whatever the browser's own bars take."""
    for _ in range(4):
        window = browser.get_window_size()
        inner = browser.execute_script("return [innerWidth, innerHeight]")
        share = 0.5 if inner[0] > 1.2 * window["width"] else 1.0
        browser.set_window_size(
            round(window["width"] + share * (width - inner[0])),
            round(window["height"] + share * (height - inner[1])),
        )


def text_of(browser: WebDriver) -> str:
    return str(browser.execute_script("return document.body ? document.body.innerText : ''"))


def reach(browser: WebDriver, attempt: Callable[[], bool], what: str) -> None:
    """Wait until something succeeds in one of the panel's tabs, which are opened in turn."""
    tabs = itertools.cycle(TABS)

    def turn() -> bool:
        if attempt():
            return True
        browser.execute_script("window.swarm?.openTab?.(arguments[0])", next(tabs))
        return False

    wait_for(turn, what)


def see(browser: WebDriver, text: str, what: str = "") -> None:
    reach(browser, lambda: text in text_of(browser), what or text)


def press(browser: WebDriver, label: str) -> None:
    script = """const b = [...document.querySelectorAll('button')].find(
        (button) => button.innerText.trim() === arguments[0]); if (b) b.click(); return !!b;"""
    reach(browser, lambda: bool(browser.execute_script(script, label)), f"a button '{label}'")


def open_tab(browser: WebDriver, name: str) -> None:
    script = """const tab = document.querySelector(`[role=tab][title='${arguments[0]}']`);
      if (tab) window.swarm.openTab(arguments[0]);
      return tab?.getAttribute('aria-selected') === 'true';"""
    wait_for(lambda: bool(browser.execute_script(script, name)), f"the tab '{name}'")


def click_canvas(browser: WebDriver, right: int, down: int) -> None:
    """Click the scene at an offset in pixels from its middle."""
    canvas = browser.find_element("css selector", "canvas")
    ActionChains(browser).move_to_element_with_offset(canvas, right, down).click().perform()


def drag_canvas(browser: WebDriver, start: tuple[int, int], by: tuple[int, int]) -> None:
    canvas = browser.find_element("css selector", "canvas")
    chain = ActionChains(browser, duration=500).move_to_element_with_offset(canvas, *start)
    chain.click_and_hold().move_by_offset(by[0] // 2, by[1] // 2)
    chain.move_by_offset(by[0] - by[0] // 2, by[1] - by[1] // 2).pause(1.0).release().perform()


def choose(browser: WebDriver, label: str, option: str) -> None:
    """Choose from the list that has a label."""

    def open_list() -> bool:
        field = labelled(browser, label)
        end = time.monotonic() + 3.0  # a folder opens slowly
        while not field.is_displayed():
            if time.monotonic() > end:  # it is in another tab
                return False
            time.sleep(0.2)
        browser.execute_script("arguments[0].scrollIntoView({ block: 'center' })", field)
        field.click()
        return True

    reach(browser, open_list, f"the list '{label}' to be in reach")
    script = """const found = [...document.querySelectorAll('[role=option]')].find(
        (x) => x.innerText.trim() === arguments[0] && x.offsetParent);
      if (found) found.click(); return !!found;"""
    wait_for(lambda: bool(browser.execute_script(script, option)), f"the option '{option}'")


def unfold(browser: WebDriver, title: str) -> None:
    script = """const found = [...document.querySelectorAll('*')].find((x) => !x.children.length
        && x.textContent.trim() === arguments[0]) ?? [...document.querySelectorAll('*')].filter(
        (x) => x.textContent.trim() === arguments[0]).pop();
      if (found) found.click(); return !!found;"""
    reach(browser, lambda: bool(browser.execute_script(script, title)), f"a folder '{title}'")


def chosen(browser: WebDriver, label: str) -> str:
    return str(labelled(browser, label).get_attribute("value"))


def tick_box(browser: WebDriver, label: str, number: int = 0) -> None:
    """Click the check box, also a hidden one, that has a label."""
    browser.execute_script("arguments[0].click()", labelled(browser, label, number))


def labelled(browser: WebDriver, label: str, number: int = 0) -> WebElement:
    """Return the input that has a label; the `number`-th of them."""
    script = """const found = [...document.querySelectorAll('label')].filter(
        (x) => (x.innerText || x.textContent).trim() === arguments[0]);
      return found.length > arguments[1] && document.getElementById(found[arguments[1]].htmlFor);"""
    reach(browser, lambda: bool(browser.execute_script(script, label, number)), f"'{label}'")
    found = browser.execute_script(script, label, number)
    assert isinstance(found, WebElement)
    return found


def click_time_line(browser: WebDriver, share: float) -> None:
    """Click the time line at a share of its length."""
    line = "[data-swarm-line]"
    wait_for(lambda: bool(browser.find_elements("css selector", line)), "the time line")
    element = browser.find_element("css selector", line)
    right = round((share - 0.5) * element.size["width"])
    ActionChains(browser).move_to_element_with_offset(element, right, -24).click().perform()


def picture(browser: WebDriver) -> np.ndarray:
    """Return what the page looks like, (height, width, 3)."""
    taken: list[bytes] = []

    def take() -> bool:
        taken.append(browser.get_screenshot_as_png())  # the driver gives up after 10 s
        return True

    wait_for(take, "a picture of the page")
    return np.asarray(Image.open(io.BytesIO(taken[-1])).convert("RGB"))


def errors(browser: WebDriver) -> list[str]:
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
