"""The window of turtlesim: a web page with the board and its turtles, from above."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from teleopctl.nodes.turtlesim.board import (
    METER,
    PIXELS,
    SIZE,
    Board,
    Colour,
    Pixels,
    turtle_picture,
)
from teleopctl.nodes.turtlesim.turtle import Turtle

if TYPE_CHECKING:
    import viser

# The page shows turtles each second period of the simulation, and new lines each sixth.
_TURTLES_EVERY, _LINES_EVERY = 2, 6
# Distance of the turtles above the board, m, so that they hide its lines, and each other's.
_ABOVE_M = 0.01
# Vertical angle of view, rad, narrow so that the board has no perspective, and the part of the
# board's height around it.
_VIEW, _MARGIN = 0.35, 1.08
_PANEL_PX = 240

_HELP = """
Steer the turtle in a terminal of its own:

`teleopctl run turtlesim turtle_teleop_key`

*{count}*
"""


class TurtleWindow:
    """Web page with the board and the turtles; draws only while a browser shows it.

    Args:
        server: Web server of the page, without content.
        clear: Called when the button for it is pressed, on a thread of the server.
        reset: See `clear`.
    """

    def __init__(
        self, server: viser.ViserServer, clear: Callable[[], object], reset: Callable[[], object]
    ) -> None:
        self._server = server
        self._ticks = 0
        self._shown: tuple[int, Colour] | None = None
        # Any: handles of viser; images of the turtles with their picture's number.
        self._board: Any = None
        self._images: list[tuple[int, Any]] = []
        self._places: list[tuple[float, float, float]] = []
        server.scene.set_up_direction("+y")
        middle = SIZE / 2.0
        camera = server.initial_camera
        camera.fov = _VIEW
        camera.position = (
            middle,
            middle,
            _MARGIN * PIXELS / METER / 2.0 / math.tan(_VIEW / 2.0),
        )
        camera.look_at = (middle, middle, 0.0)
        camera.up = (0.0, 1.0, 0.0)
        # Beside the board, not in front of it.
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_PANEL_PX)
        server.gui.set_panel_label("TurtleSim")
        self._help: Any = server.gui.add_markdown("")
        # Any: the event of a press.
        for label, act in (("Clear", clear), ("Reset", reset)):

            def press(_: Any, act: Callable[[], object] = act) -> None:
                act()

            server.gui.add_button(label).on_click(press)

    def show(self, board: Board, background: Colour, turtles: Iterable[Turtle]) -> None:
        """Draw the board and the turtles; called once in each period of the simulation."""
        self._ticks += 1
        # What has not been drawn yet is drawn once a browser is there.
        if not self._server.get_clients() and self._board is not None:
            return
        if self._ticks % _LINES_EVERY == 0 or self._board is None:
            self._show_lines(board, background)
        if self._ticks % _TURTLES_EVERY == 0:
            self._show_turtles(list(turtles))

    def _show_lines(self, board: Board, background: Colour) -> None:
        if self._shown == (board.drawn, background):
            return
        self._shown = (board.drawn, background)
        picture = _upright(board.picture(background))
        if self._board is None:
            side = PIXELS / METER
            self._board = self._server.scene.add_image(
                "/board",
                picture,
                side,
                side,
                format="png",
                cast_shadow=False,
                receive_shadow=False,
                position=(SIZE / 2.0, SIZE / 2.0, 0.0),
            )
        else:
            self._board.image = picture

    def _show_turtles(self, turtles: list[Turtle]) -> None:
        looks = [turtle.look for turtle in turtles]
        if looks != [look for look, _ in self._images]:
            for _, image in self._images:
                image.remove()
            self._images = [
                (look, self._add_turtle(place, look)) for place, look in enumerate(looks)
            ]
            self._places = [(math.nan, math.nan, math.nan)] * len(looks)
            count = "1 turtle" if len(looks) == 1 else f"{len(looks)} turtles"
            self._help.content = _HELP.format(count=count)
        for number, turtle in enumerate(turtles):
            place = (turtle.x, turtle.y, turtle.theta)
            if place != self._places[number]:
                self._places[number] = place
                image = self._images[number][1]
                image.position = (turtle.x, SIZE - turtle.y, _ABOVE_M * (number + 1))
                # The turtle in the picture faces up, which is the direction pi/2.
                image.wxyz = _turned(turtle.theta - math.pi / 2.0)

    def _add_turtle(self, number: int, look: int) -> Any:
        return self._server.scene.add_image(
            f"/turtles/{number}",
            _upright(turtle_picture(look)),
            1.0,
            1.0,
            cast_shadow=False,
            receive_shadow=False,
        )


def _upright(picture: Pixels) -> Pixels:
    """Return a picture for viser, whose images have their first row at the lowest y."""
    return picture[::-1]


def _turned(angle: float) -> tuple[float, float, float, float]:
    """Return the quaternion w, x, y, z of a rotation about z, rad."""
    return math.cos(angle / 2.0), 0.0, 0.0, math.sin(angle / 2.0)
