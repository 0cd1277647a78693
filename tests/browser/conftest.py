"""A headless browser: Debian's chromium and chromium-driver. Run with `-m long tests/browser`."""

import shutil
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

from tests.browser.page import resize

SIZE = 760, 520  # pixels cost: they are drawn without a GPU
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--force-device-scale-factor=0.5",
)


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Yield a browser; left out where there is none."""
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("no browser; on Debian: apt install chromium chromium-driver")
    options = Options()
    options.binary_location = chromium
    profile: Path = tmp_path_factory.mktemp("profile")
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    with webdriver.Chrome(options=options, service=Service(driver)) as found:
        resize(found, *SIZE)
        found.set_page_load_timeout(90)
        found.set_script_timeout(90)
        yield found
