"""Executable ``rviz2``: serves the web page that shows the robot, in place of RViz."""

from __future__ import annotations

import argparse
import contextlib
import gc
import html
import os
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.base import progress
from teleopctl.base.files import write_private
from teleopctl.base.folders import make_private, runtime_dir
from teleopctl.base.token_file import Address
from teleopctl.errors import UsageError
from teleopctl.node import ExternalShutdownException, init, parse_ros_arguments, spin

if TYPE_CHECKING:
    from teleopctl.viewer import PageLayout

# Threshold of the garbage collector: a message with a thousand markers has about as many objects.
_NEW_OBJECTS = 20_000
_NICENESS = 5
OPEN_VARIABLE = "TELEOPCTL_OPEN"
"""Environment variable that makes RViz open its page in the browser."""


def main(args: list[str] | None = None) -> int:
    """Serve the viewer's web page until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        PageError: The page cannot be opened.
        LayoutError: There is no such layout.
    """
    return serve_page("rviz2", sys.argv[1:] if args is None else args)


def serve_page(program: str, words: list[str], layout: PageLayout | None = None) -> int:
    """Serve the viewer's web page, as `main`.

    Args:
        program: Name of the program.
        words: Command line of the program, without its name.
        layout: Layout of the panels, unless the command line has another one.
    """
    from teleopctl.nodes.teleop.drive_page.page import DrivePage
    from teleopctl.viewer import PageRoutes, load_layout, open_viewer

    parser = argparse.ArgumentParser(
        prog=program, description="The robot in a browser.", allow_abbrev=False
    )
    parser.add_argument("-d", "--display-config", default="", help="an .rviz file to begin with")
    parser.add_argument(
        "--layout", metavar="NAME|FILE", default="", help="layout of the panels: a preset or a file"
    )
    add_page_options(parser)
    options, unserved = parser.parse_known_args(parse_ros_arguments(words).program)
    if options.layout:
        layout = load_layout(options.layout)
    progress.report(progress.STARTING)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=words, publishes_after_signal=True),
    ):
        routes, drive = PageRoutes(), DrivePage()
        drive.add_to(routes)
        viewer, address = open_viewer(
            options.host,
            options.port,
            options.token_file,
            view=Path(options.display_config) if options.display_config else None,
            layout=layout,
            routes=routes,
        )
        with contextlib.closing(drive), viewer as node:
            drive.attach(node)
            drive.use_sim_time = bool(node.get_parameter("use_sim_time").value)
            if unserved:
                # For example -f for the fixed frame, which is set in the .rviz file or on the page.
                node.get_logger().warning(f"Without effect on the page: {' '.join(unserved)}")
            node.get_logger().info(f"The robot is at {address.url}")
            report_address(address, open_it=options.open)
            _spare_collections()
            if hasattr(os, "nice"):
                # The processes that control the robot have priority over drawing. On Linux it is
                # that of this thread alone: not of the start, and not of the operator's inputs.
                os.nice(_NICENESS)
            spin(node)
    return 0


def _spare_collections() -> None:
    """Collect garbage less often, and exclude the objects that exist since the start.

    The objects that are drawn ten times a second have no reference cycles. With this, a thousand
    moving cubes use a fifth less of a core.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(_NEW_OBJECTS, *gc.get_threshold()[1:])


def report_address(address: Address, *, open_it: bool) -> None:
    """Report the web page as ready in the progress file; open it in a browser if requested."""
    progress.report_ready_at(address)
    if open_it or os.environ.get(OPEN_VARIABLE):
        open_in_browser(address)


def open_in_browser(address: Address) -> None:
    """Open a web page in the browser, without its access token among process arguments.

    All users can list the arguments of the browser's process. So for an address with a token, the
    browser opens a private file of the user that redirects to the address.
    """
    if address.token_file is None:
        webbrowser.open(address.url)
        return
    file = runtime_dir() / "open_page.html"
    make_private(file.parent)
    target = html.escape(address.with_token)
    write_private(file, f'<meta http-equiv="refresh" content="0; url={target}">\n')
    webbrowser.open(file.as_uri())


class _NoToken(argparse.Action):
    """Action that rejects a token on the command line, which all users of the machine can read."""

    def __call__(self, *_: object) -> None:
        raise UsageError(
            "--token would show the token in the list of processes",
            hint="Write it into a file of mode 0600: --token-file FILE. Without one, one is made.",
        )


def add_page_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the web page (``--host``, ``--port`` …) to a parser."""
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on")
    parser.add_argument(
        "--port",
        # Launch files have it empty for the default.
        type=lambda text: int(text) if text else None,
        help="port to listen on; by default 8080, or the next free one",
    )
    parser.add_argument(
        "--token-file",
        type=lambda file: Path(file).expanduser(),
        metavar="FILE",
        help="file of the page's access token; created if missing",
    )
    parser.add_argument("--token", action=_NoToken, help=argparse.SUPPRESS)
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
