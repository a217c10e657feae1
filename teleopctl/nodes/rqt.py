"""Executables ``rqt``, ``rqt_graph``, ``rqt_plot`` and so on: the page with the panel of each tool.

Tools without a panel name the commands that replace them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from teleopctl.errors import UnsupportedError
from teleopctl.nodes.rviz2 import serve_page

_PANELS = {
    "image_view": "camera",
    "plotjuggler": "plot",
    "rqt_bag": "bag",
    "rqt_console": "log",
    "rqt_controller_manager": "controllers",
    "rqt_graph": "graph",
    "rqt_image_view": "camera",
    "rqt_joint_trajectory_controller": "joints",
    "rqt_plot": "plot",
    "rqt_reconfigure": "parameters",
    "rqt_topic": "topics",
}
"""Panel of the page for each tool."""

_COMMANDS = {
    "rqt_action": "teleopctl action list",
    "rqt_logger_level": "teleopctl logger set NODE LEVEL",
    "rqt_msg": "teleopctl interface show TYPE",
    "rqt_publisher": "teleopctl topic pub TOPIC TYPE VALUES",
    "rqt_robot_steering": "teleopctl run teleop_twist_keyboard teleop_twist_keyboard",
    "rqt_service_caller": "teleopctl service call SERVICE TYPE VALUES",
    "rqt_srv": "teleopctl interface show TYPE",
    "rqt_tf_tree": "teleopctl tf view_frames",
    "rqt_top": "teleopctl top",
}
"""Command that replaces each tool without a panel."""


def rqt() -> int:
    """Serve the page, as ``rqt``; with ``-s TOOL`` with the panel of one tool.

    Raises:
        UnsupportedError: The page has no panel for the tool.
    """
    words = sys.argv[1:]
    for flag in ("-s", "--standalone"):
        if flag in words[:-1]:
            place = words.index(flag)
            tool = words[place + 1].partition(".")[0]
            return _serve(tool, words[:place] + words[place + 2 :])
    return serve_page("rqt", [word for word in words if word != "--force-discover"])


def _run(tool: str) -> int:
    return _serve(tool, sys.argv[1:])


def _serve(tool: str, words: list[str]) -> int:
    panel = _PANELS.get(tool)
    if panel is not None:
        from teleopctl.viewer import PageLayout

        states = {}
        named = [word for word in words if word.startswith("/")]
        if named and panel in ("plot", "camera"):
            words = [word for word in words if word not in named]
            states[panel] = _plots(named) if panel == "plot" else dict.fromkeys(named, True)
        return serve_page(tool, words, replace(PageLayout.with_panels([panel]), states=states))
    command = _COMMANDS.get(tool)
    raise UnsupportedError(
        f"The page has no {tool}",
        hint=f"Instead: `{command}`" if command else f"It has {', '.join(sorted(_PANELS))}.",
    )


# Any: YAML values of a layout.
def _plots(words: list[str]) -> dict[str, Any]:
    """Return the state of the plot panel with a plot of fields such as ``/odom/pose/x:y``."""
    topics = _published()
    lines = []
    for word in words:
        first, *more = word.split(":")
        begin = first.rpartition("/")[0]
        for field in (first, *(f"{begin}/{name}" for name in more)):
            known = [topic for topic in topics if field.startswith(f"{topic}/")]
            lines.append({"line": field, "topics": known or [field.rpartition("/")[0]]})
    return {"plots": [lines]}


def _published() -> list[str]:
    """Return the topics of the graph; none where no router runs."""
    from teleopctl.wire import RouterNotRunning, open_session, query_graph

    try:
        with open_session("client") as session:
            return [topic for topic, _ in query_graph(session).topic_names_and_types()]
    except RouterNotRunning:
        return []


def __getattr__(tool: str) -> Callable[[], int]:
    """Return the program of a tool, whose name is that of its package.

    Raises:
        AttributeError: There is no such tool.
    """
    if tool not in _PANELS and tool not in _COMMANDS:
        raise AttributeError(f"module {__name__!r} has no attribute {tool!r}")
    return partial(_run, tool)
