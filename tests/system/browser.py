"""A real browser for tests of the page: Chromium of the system, driven by Playwright."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "msedge")
# WebGL without a graphics card.
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def chromium_program() -> str:
    """Find the browser; skips the test where there is none."""
    program = next(filter(None, map(shutil.which, _NAMES)), None)
    if program is None:
        pytest.skip("There is no Chromium; on Debian and Ubuntu: apt install chromium")
    return program


@contextmanager
def browser() -> Iterator[Browser]:
    """Start a browser without a window; skips the test where there is none."""
    program = chromium_program()
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", *SOFTWARE_GL]
        )
        try:
            yield started
        finally:
            started.close()


# Software draws a picture of the page in a tenth of a second, and a page draws all the time.
_FEW_PICTURES = """
const draw = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (callback) => setTimeout(() => draw(callback), 200);
window.cancelAnimationFrame = clearTimeout;
"""


def open_page(browser: Browser, address: str, *, width: int = 900, height: int = 640) -> Page:
    """Open a page that draws at most five pictures per second, so that the tests get the cores."""
    page = browser.new_page(viewport={"width": width, "height": height})
    page.add_init_script(_FEW_PICTURES)
    page.goto(address)
    return page
