"""Fixtures of the tests of displays."""

from tests.viewer.displays.conftest import draw, picture

__all__ = ["draw", "picture"]
