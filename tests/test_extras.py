"""What `pip install teleopctl` leaves out is named with the line that installs it."""

import sys

import pytest

from teleopctl.errors import MissingExtraError
from teleopctl.extras import extra


def test_a_missing_extra_is_named_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(MissingExtraError, match="foxglove") as raised, extra("fox", "foxglove"):
        import foxglove.websocket  # noqa: F401
    assert raised.value.hint == "Install it with: pip install 'teleopctl[fox]'"


def test_another_module_that_is_missing_is_a_defect():
    with pytest.raises(ModuleNotFoundError), extra("fox", "foxglove"):
        import no_such_module  # type: ignore[import-not-found]  # noqa: F401
