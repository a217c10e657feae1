"""Take the film of README in which somebody drives: ``python docs/images/make_drive_film.py``.

From the command to the cube in the bin, by keys, in one take: a browser without a window opens the
page, a program that sees where gripper and cube are holds the keys, and the pictures that the
browser draws meanwhile become the film. It prints how long each part took. The repository's folder
has to be on ``PYTHONPATH``. Needs the extra ``test`` (Playwright) and Chromium.
"""

from __future__ import annotations

import base64
import io
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw, ImageFont
from playwright.sync_api import Page, sync_playwright

from teleopctl.testing import RosGraph
from tests import ROOT
from tests.system.browser import SOFTWARE_GL, chromium_program, open_page
from tests.system.driving import KeysHand, driver

FILE = Path(__file__).with_name("drive.webp")
MODEL = str(ROOT / "robot/urdf/teleop.urdf.xacro")
SIZE, SHOWN = (1000, 625), (800, 500)
# The film is this much faster than what happened, with pictures so far apart at least, s.
SPEED, LEAST_S = 3.0, 0.4
TERMINAL_S, END_S = 2.5, 2.0
COMMAND = "$ teleopctl drive"


class Film:
    """Pictures with the times at which they were drawn, in s from the command."""

    def __init__(self) -> None:
        self.begun_s = time.time()
        self.pictures: list[tuple[float, Image.Image]] = []

    def add(self, picture: Image.Image, at_s: float) -> None:
        """Add a picture, unless one was just added."""
        if not self.pictures or at_s - self.pictures[-1][0] >= LEAST_S:
            self.pictures.append((at_s, picture.convert("RGB").resize(SHOWN)))

    def watch(self, page: Page) -> None:
        """Add the pictures that a page draws from now on."""
        session = page.context.new_cdp_session(page)

        # Any: an event of the DevTools protocol.
        def take(event: Any) -> None:
            picture = Image.open(io.BytesIO(base64.b64decode(event["data"])))
            self.add(picture, float(event["metadata"]["timestamp"]) - self.begun_s)
            session.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

        session.on("Page.screencastFrame", take)
        session.send("Page.startScreencast", {"format": "jpeg", "quality": 90})

    def write(self, lines: list[str]) -> None:
        """Write the film, with the terminal's lines at its beginning."""
        times = [at_s for at_s, _ in self.pictures]
        after = [*times[1:], times[-1] + END_S * SPEED]
        lengths = [(b - a) / SPEED for a, b in zip(times, after, strict=True)]
        pictures = [_terminal(lines), *(picture for _, picture in self.pictures)]
        pictures[0].save(
            FILE,
            save_all=True,
            append_images=pictures[1:],
            duration=[round(1e3 * length) for length in (TERMINAL_S, *lengths)],
            loop=0,
            quality=60,
            method=6,
        )
        sys.stdout.write(f"{FILE}: {len(pictures)} pictures, {FILE.stat().st_size} bytes\n")


def _terminal(lines: list[str]) -> Image.Image:
    picture = Image.new("RGB", SHOWN, (20, 23, 28))
    draw = ImageDraw.Draw(picture)
    for number, line in enumerate([COMMAND, *lines]):
        colour = (232, 235, 240) if number else (57, 168, 107)
        place = (24, 28 + 30 * number)
        draw.text(place, line[:96], fill=colour, font=ImageFont.load_default(15))
    return picture


def main() -> None:
    """Drive, and write the film."""
    with tempfile.TemporaryDirectory() as folder, RosGraph(Path(folder)) as ros:
        begun_s = time.monotonic()

        def say(what: str) -> None:
            sys.stdout.write(f"{time.monotonic() - begun_s:6.1f} s  {what}\n")
            sys.stdout.flush()

        command = ros.spawn("drive --port 0 --no-open")
        address = command.wait_for_line(r"^Mouse: +(\S+/drive) ")[1]
        lines = [command.wait_for_line(rf"^{name}:.*")[0] for name in ("Keys", "Gamepad", "Phone")]
        say("the page's address is printed")
        with sync_playwright() as playwright, driver(MODEL) as person:
            browser = playwright.chromium.launch(
                executable_path=chromium_program(), args=["--no-sandbox", *SOFTWARE_GL]
            )
            page = open_page(browser, address, *SIZE, draws=True)
            page.wait_for_function("document.getElementById('robot').textContent == 'Drive teleop'")
            person.wait()
            say("the robot can be driven")
            page.wait_for_timeout(8_000)  # software draws it
            film = Film()
            film.watch(page)
            person.pause = lambda seconds: page.wait_for_timeout(1e3 * seconds)
            keys = KeysHand(page, person)
            say("the first key is pressed")
            keys.grip(1.0)
            person.wait_for_fingers()
            say("the gripper moves")
            keys.let_go()
            is_there = person.bring_cube(keys)
            say("the cube is in the bin" if is_there else "the cube is not in the bin")
            page.wait_for_timeout(1_000)
            browser.close()
        film.write([f"Mouse:   {address}  drag the handle at the gripper", *lines])
        command.interrupt()
        command.wait()
    if not is_there:
        raise SystemExit("The cube is not in the bin")


if __name__ == "__main__":
    main()
