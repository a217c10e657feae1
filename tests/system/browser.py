"""Real browser for tests of the page: Chromium of the system, driven by Playwright."""

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
    """Return the path of Chromium; skip the test if Chromium is not installed."""
    program = next(filter(None, map(shutil.which, _NAMES)), None)
    if program is None:
        pytest.skip("There is no Chromium; on Debian and Ubuntu: apt install chromium")
    return program


@contextmanager
def browser() -> Iterator[Browser]:
    """Start a headless browser; skip the test if Chromium is not installed."""
    program = chromium_program()
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", *SOFTWARE_GL]
        )
        try:
            yield started
        finally:
            started.close()


# Pictures are rendered in software: a low frame rate and a small environment map leave the cores to
# the tests.
_LITTLE_TO_DRAW = """
const draw = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (callback) => setTimeout(() => draw(callback), 200);
window.cancelAnimationFrame = clearTimeout;
const decode = window.createImageBitmap.bind(window);
const small = {resizeWidth: 16, resizeHeight: 8};
window.createImageBitmap = (image, ...options) =>
  image instanceof Blob ? decode(image, small) : decode(image, ...options);
"""


def open_page(
    browser: Browser, address: str, width: int = 900, height: int = 640, script: str = ""
) -> Page:
    """Open a page of the viewer that renders a few pictures per second, after a script."""
    page = browser.new_page(viewport={"width": width, "height": height}, has_touch=width < 500)
    page.add_init_script(_LITTLE_TO_DRAW + script)
    page.goto(address)
    return page
