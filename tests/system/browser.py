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
# The page around the WebGL picture is not drawn by the emulated graphics card, which takes longer.
LITTLE_TO_COMPOSE = ["--disable-gpu-compositing"]


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
            executable_path=program, args=["--no-sandbox", *SOFTWARE_GL, *LITTLE_TO_COMPOSE]
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
# Compiling the shaders takes seconds. With these the picture stays empty; where the mouse points
# is not computed from the picture.
_NOTHING_TO_DRAW = """
const compile = WebGL2RenderingContext.prototype.shaderSource;
WebGL2RenderingContext.prototype.shaderSource = function (shader) {
  const isVertex = this.getShaderParameter(shader, this.SHADER_TYPE) === this.VERTEX_SHADER;
  compile.call(this, shader, "#version 300 es\\n" + (isVertex
    ? "void main() { gl_Position = vec4(0); }"
    : "precision lowp float; out vec4 colour; void main() { colour = vec4(0); }"));
};
"""


def open_page(
    browser: Browser,
    address: str,
    width: int = 900,
    height: int = 640,
    script: str = "",
    *,
    draws: bool = False,
) -> Page:
    """Open a page of the viewer that is drawn a few times per second, after a script.

    Args:
        browser: The browser.
        address: URL of the page.
        width: Width of the page in pixels.
        height: Its height in pixels.
        script: JavaScript that the page runs first.
        draws: Whether the 3D view is drawn; otherwise it stays empty.
    """
    page = browser.new_page(viewport={"width": width, "height": height}, has_touch=width < 500)
    page.add_init_script(_LITTLE_TO_DRAW + ("" if draws else _NOTHING_TO_DRAW) + script)
    page.goto(address)
    return page
