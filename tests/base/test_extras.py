"""What `pip install teleopctl` leaves out is named with the line that installs it."""

import importlib.metadata
import json
import sys
from pathlib import Path

import pytest

from teleopctl.base.extras import extra, missing_module_hint
from teleopctl.errors import MissingExtraError
from tests import ROOT


@pytest.fixture
def hint(monkeypatch):
    """The advice about a missing library, with a record of where teleopctl came from."""

    def hint(origin: object) -> str | None:
        class Installed:
            def read_text(self, _: str) -> str | None:
                return json.dumps(origin) if origin else None

        monkeypatch.setattr(importlib.metadata, "distribution", lambda _: Installed())
        monkeypatch.setitem(sys.modules, "foxglove", None)
        with pytest.raises(MissingExtraError, match="foxglove") as raised, extra("fox", "foxglove"):
            import foxglove.websocket  # noqa: F401
        return raised.value.hint

    return hint


def test_a_missing_extra_is_installed_from_the_folder_that_teleopctl_came_from(
    hint, tmp_path, monkeypatch
):
    checkout = tmp_path / "a checkout"
    checkout.mkdir()
    origin = {"url": checkout.as_uri(), "dir_info": {}}
    assert hint(origin) == f"Install it with: pip install '{checkout}[fox]'"
    monkeypatch.chdir(checkout)
    assert hint(origin) == "Install it with: pip install '.[fox]'"


def test_a_checkout_that_is_only_on_the_path_is_that_folder(hint):
    assert hint(None) == f"Install it with: pip install '{_from_here(ROOT)}[fox]'"


def _from_here(folder: Path) -> str:
    return "." if Path.cwd() == folder else str(folder)


@pytest.mark.parametrize(
    ("origin", "requirement"),
    [
        (
            {"url": "https://example.org/t.git", "vcs_info": {"vcs": "git", "commit_id": "abc"}},
            "teleopctl[fox] @ git+https://example.org/t.git@abc",
        ),
        (
            {"url": "https://example.org/teleopctl.whl", "archive_info": {}},
            "teleopctl[fox] @ https://example.org/teleopctl.whl",
        ),
        ({"url": "file:///no/such/folder", "dir_info": {"editable": True}}, "teleopctl[fox]"),
    ],
)
def test_a_missing_extra_is_installed_from_the_address_that_teleopctl_came_from(
    hint, origin, requirement
):
    assert hint(origin) == f"Install it with: pip install '{requirement}'"


def test_what_came_from_a_package_index_comes_from_there_again(hint, monkeypatch, tmp_path):
    monkeypatch.setattr(
        "teleopctl.base.extras.__file__", str(tmp_path / "teleopctl" / "base" / "extras.py")
    )
    assert hint(None) == "Install it with: pip install 'teleopctl[fox]'"


def test_another_module_that_is_missing_is_a_defect():
    with pytest.raises(ModuleNotFoundError), extra("fox", "foxglove"):
        import no_such_module  # type: ignore[import-not-found]  # noqa: F401


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("urdf_parser_py.urdf", "It is not installed: pip install urdf-parser-py"),
        ("transforms3d", "It is not installed: pip install transforms3d"),
        ("qt_gui.plugin", "Plug-ins of rqt need Qt, which is not here"),
        ("rospy", "rospy is of ROS 1; in ROS 2 it is rclpy."),
        ("nobody_knows_it", None),
    ],
)
def test_a_module_that_is_not_found_has_a_hint_where_something_can_be_done(module, said):
    hint = missing_module_hint(ModuleNotFoundError("No module", name=module))
    assert hint == said or (hint is not None and hint.startswith(said))
