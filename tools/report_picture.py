"""Draw the picture of a report in docs/, in a headless browser.

Usage: python -m tools.report_picture RUN [--out docs/report.png] [--dark]
Needs Debian's packages chromium and chromium-driver, and the extra `dev`.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

from swarm_report.document import document_html
from swarm_report.run import RunData

FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
SIZE = (1240, 1660)
LIMIT = 60.0  # [s] of wall time until the plots in view are there
DRAWN = "return document.querySelectorAll('.is-live .main-svg').length"
COLORS = 128


def take(run: Path, is_dark: bool) -> Image.Image:
    """Return a picture of the top of a run's page."""
    with tempfile.TemporaryDirectory() as folder, open_chromium(FLAGS) as browser:
        page = Path(folder) / "report.html"
        page.write_text(document_html(RunData(run)), encoding="utf-8")
        browser.set_window_size(*SIZE)
        browser.get(page.as_uri())
        if is_dark:
            browser.execute_script("document.getElementById('theme').click()")
        end = time.monotonic() + LIMIT
        while time.monotonic() < end and not browser.execute_script(DRAWN):
            time.sleep(0.2)
        time.sleep(3.0)  # for those beside and below the first
        return Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")


def open_chromium(flags: Sequence[str]) -> webdriver.Chrome:
    """Return Debian's browser, started with these flags."""
    options = Options()
    options.binary_location = "/usr/bin/chromium"
    for flag in flags:
        options.add_argument(flag)
    return webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))


def main() -> int:
    """Draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("run", type=Path)
    parser.add_argument("--out", type=Path, default=Path("docs/report.png"))
    parser.add_argument("--dark", action="store_true")
    options = parser.parse_args()
    picture = take(options.run, options.dark)
    picture.quantize(COLORS, dither=Image.Dither.NONE).save(options.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
