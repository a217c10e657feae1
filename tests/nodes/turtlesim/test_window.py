"""The page shows the board and its turtles, up to date while a browser is there."""

import math
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.nodes.turtlesim.board import BACKGROUND, SIZE, Board, Colour, Pen
from teleopctl.nodes.turtlesim.window import TurtleWindow
from teleopctl.viewer import close_server, open_server


def turtle(x: float, y: float, theta: float, look: int = 0) -> Any:
    return SimpleNamespace(x=x, y=y, theta=theta, look=look)


def test_lines_background_and_turtles_are_drawn_where_they_are():
    server = open_server(port=0)
    try:
        window = TurtleWindow(server, lambda: None, lambda: None)
        board, there = Board(), [turtle(2.0, 3.0, math.pi / 2)]
        window.show(board, BACKGROUND, there)
        server.get_clients = lambda: {0: None}  # type: ignore[method-assign, dict-item]
        board.line((1.0, 1.0), (2.0, 1.0), Pen(Colour(255, 0, 0)))
        for _ in range(6):
            window.show(board, Colour(1, 2, 3), there)
        # viser's pictures have their lowest row first.
        picture = window._board.image[::-1]
        assert tuple(picture[90, 135]) == (255, 0, 0)
        assert tuple(picture[0, 0]) == (1, 2, 3)
        ((_, shown),) = window._images
        assert tuple(shown.position)[:2] == pytest.approx((2.0, SIZE - 3.0))
        assert tuple(shown.wxyz) == pytest.approx((1.0, 0.0, 0.0, 0.0))
        there.append(turtle(5.0, 5.0, 0.0, look=1))
        for _ in range(2):
            window.show(board, BACKGROUND, there)
        assert len(window._images) == 2
        assert "2 turtles" in window._help.content
    finally:
        close_server(server)
