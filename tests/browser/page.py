"""What a person sees and does on a page of the viewer."""

from __future__ import annotations

import io
import time
from collections.abc import Callable

import numpy as np
from PIL import Image
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.remote.webdriver import WebDriver

LIMIT = 90.0  # [s] of wall time for anything to show; software rendering on a busy machine
# The last one is what viser's client does when something that can be dragged is pressed.
HARMLESS = ("Software WebGL", "deprecated", "GPU stall", "favicon", "passive event listener")


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


def text_of(browser: WebDriver) -> str:
    """Return all that can be read on the page."""
    return str(browser.execute_script("return document.body ? document.body.innerText : ''"))


def press(browser: WebDriver, label: str) -> None:
    """Press the button with a label."""
    script = """const b = [...document.querySelectorAll('button')].find(
        (button) => button.innerText.trim() === arguments[0]); if (b) b.click(); return !!b;"""
    wait_for(lambda: bool(browser.execute_script(script, label)), f"a button '{label}'")


def click_canvas(browser: WebDriver, right: int, down: int) -> None:
    """Click the scene at an offset in pixels from its middle."""
    canvas = browser.find_element("css selector", "canvas")
    ActionChains(browser).move_to_element_with_offset(canvas, right, down).click().perform()


def picture(browser: WebDriver) -> np.ndarray:
    """Return what the page looks like, (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB"))


def errors(browser: WebDriver) -> list[str]:
    """Return what went wrong on the page since the last call."""
    return [
        entry["message"]
        for entry in browser.get_log("browser")
        if entry["level"] == "SEVERE" and not any(word in entry["message"] for word in HARMLESS)
    ]
