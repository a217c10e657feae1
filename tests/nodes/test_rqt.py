"""rqt's tools: each has its panel of the page, or the command that stands for it."""

from typing import Any

import pytest

from teleopctl import plugins
from teleopctl.errors import UnsupportedError
from teleopctl.nodes import rqt


@pytest.fixture
def served(monkeypatch):
    """What is served: program, words, panels and their states."""
    pages: list[Any] = []

    def serve(program: str, words: list[str], layout: Any = None) -> int:
        pages.append((program, words, layout and layout.names(), layout and dict(layout.states)))
        return 0

    monkeypatch.setattr(rqt, "serve_page", serve)
    monkeypatch.setattr(rqt, "_published", lambda: ["/odom", "/odom/pose", "/tf"])
    return pages


def start(monkeypatch, program: str, *words: str) -> int:
    monkeypatch.setattr("sys.argv", [program, *words])
    return int(getattr(rqt, program)())


def test_a_tool_opens_the_page_at_its_panel(served, monkeypatch):
    assert start(monkeypatch, "rqt_console", "--port", "8090") == 0
    assert start(monkeypatch, "rqt", "--force-discover") == 0
    assert start(monkeypatch, "rqt", "-s", "rqt_graph.ros_graph.RosGraph", "--open") == 0
    assert served == [
        ("rqt_console", ["--port", "8090"], ["log"], {}),
        ("rqt", [], None, None),
        ("rqt_graph", ["--open"], ["graph"], {}),
    ]


def test_fields_and_images_that_are_named_are_shown_at_once(served, monkeypatch):
    start(monkeypatch, "rqt_plot", "/odom/pose/position/x:y", "/later/data")
    start(monkeypatch, "rqt_image_view", "/camera/image_raw")
    (_, _, _, plots), (_, _, _, images) = served
    known = ["/odom", "/odom/pose"]
    assert plots == {
        "plot": {
            "plots": [
                [
                    {"line": "/odom/pose/position/x", "topics": known},
                    {"line": "/odom/pose/position/y", "topics": known},
                    {"line": "/later/data", "topics": ["/later"]},
                ]
            ]
        }
    }
    assert images == {"camera": {"/camera/image_raw": True}}


def test_a_tool_without_a_panel_names_the_command_that_stands_for_it(served, monkeypatch):
    with pytest.raises(UnsupportedError, match="The page has no rqt_tf_tree") as raised:
        start(monkeypatch, "rqt_tf_tree")
    assert raised.value.hint == "Instead: `teleopctl tf view_frames`"
    with pytest.raises(UnsupportedError, match="The page has no rqt_unknown"):
        start(monkeypatch, "rqt", "-s", "rqt_unknown")
    assert not served


def test_every_tool_has_a_program_and_every_program_a_tool():
    programs = {
        target.partition(":")[2]
        for name, target in plugins.NODES.builtin.items()
        if ".nodes.rqt:" in target and name.partition("/")[0] not in ("rqt", "rqt_gui")
    }
    assert programs == {*rqt._PANELS, *rqt._COMMANDS}
    assert {*rqt._PANELS.values()} <= plugins.PANELS.builtin.keys()
    with pytest.raises(AttributeError):
        rqt.rqt_unknown  # noqa: B018
