"""What the tests of displays share."""

from tests.viewer.displays.conftest import draw, picture

__all__ = ["draw", "picture"]
