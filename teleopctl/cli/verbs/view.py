"""``teleopctl view``: the page of the running robot, of a bag, a robot, a view or a layout."""

import os
from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import NotFoundError, UsageError

VERB = Verb(
    f"{__name__}:view",
    "Open the page: the running robot, a bag, a robot's file, a view or a layout.",
    examples=(
        "teleopctl view",
        "teleopctl view session",
        "teleopctl view session --over other_session",
        "teleopctl view my_robot.urdf.xacro",
        "teleopctl view my_robot.rviz",
    ),
)

_ROBOTS = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf")
_BAGS = (".mcap", ".db3")
_LAYOUTS = (".yaml", ".yml")


def view(
    thing: Annotated[
        str | None,
        Argument(
            metavar="[FILE|BAG|ROBOT]",
            help="A bag, a robot's file, an .rviz file or a layout; by default the running robot.",
            complete="files",
        ),
    ] = None,
    layout: Annotated[
        str | None,
        Option("--layout", help="Layout of the page: a preset or a file.", metavar="NAME|FILE"),
    ] = None,
    over: Annotated[
        str | None,
        Option(
            "--over",
            help="Of a bag: a second bag to show over it, as of `teleopctl bag view`.",
            metavar="BAG",
            complete="files",
        ),
    ] = None,
    host: Annotated[str, Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[
        int | None,
        Option("--port", help="Port to listen on; by default 8080, or the next free one."),
    ] = None,
    no_open: Annotated[
        bool, Option("--no-open", help="Print the address, and open no browser.")
    ] = False,
) -> int | None:
    """Serve the page of a thing until Ctrl-C, and open it in the browser.

    A bag is played as by `teleopctl bag view`, a robot's file is displayed as by `teleopctl launch
    display.yaml`, and all else is the page alone, as of `teleopctl run rviz2 rviz2`.
    """
    kind = _kind_of(thing)
    if over is not None and kind != "bag":
        raise UsageError(
            f"--over {over}: a bag is shown over another bag",
            hint=f"With the first bag's name: teleopctl view BAG --over {over}",
        )
    if kind == "bag":
        from teleopctl.cli.verbs.bag.view import view as view_bag

        _refuse(layout, "A bag has the layout 'bag'")
        view_bag(str(thing), over=over, host=host, port=port, open_page=not no_open)
        return None
    if kind == "robot":
        from teleopctl.cli.verbs.launch import launch

        if host != "127.0.0.1" or port is not None:
            raise UsageError(
                "A robot's file is displayed by display.yaml, whose page is on this machine",
                hint=f"For another address: teleopctl launch --detach display.yaml model:={thing} "
                "viewer:=false && teleopctl view --host HOST",
            )
        if not no_open:
            from teleopctl.nodes.rviz2 import OPEN_VARIABLE

            os.environ[OPEN_VARIABLE] = "true"
        chosen = [f"layout:={layout}"] if layout else []
        return launch(["display.yaml", f"model:={thing}", *chosen])
    from teleopctl.cli.verbs.run import run

    words = ["rviz2", "rviz2", "--host", host]
    words += [] if port is None else ["--port", str(port)]
    words += [] if no_open else ["--open"]
    words += ["-d", str(thing)] if kind == "view" else []
    if kind == "layout":
        _refuse(layout, f"{thing} is a layout itself")
        layout = thing
    return run([*words, "--layout", layout] if layout else words)


def _kind_of(thing: str | None) -> str:
    """Return the kind of a path: bag, robot, view or layout; empty without a path.

    Raises:
        TeleopctlError: There is no such file, or it is none of these.
    """
    if thing is None:
        return ""
    path = Path(thing)
    if not path.exists():
        raise NotFoundError(
            f"{thing}: no such file",
            hint="`teleopctl view` opens a bag, a robot's file, an .rviz file or a layout; "
            "without a name, the running robot.",
        )
    if path.is_dir():
        if (path / "metadata.yaml").exists() or any(path.glob("*.mcap")):
            return "bag"
        raise UsageError(f"{thing} is a folder without a bag", hint="A bag has a metadata.yaml.")
    for kind, endings in (("bag", _BAGS), ("robot", _ROBOTS), ("layout", _LAYOUTS)):
        if path.suffix in endings:
            return kind
    if path.suffix == ".rviz":
        return "view"
    raise UsageError(
        f"{thing} is neither a bag nor a robot's file, an .rviz file or a layout",
        hint=f"Robots end with {', '.join(_ROBOTS)}; bags with {', '.join(_BAGS)}.",
    )


def _refuse(layout: str | None, why: str) -> None:
    if layout is not None:
        raise UsageError(f"--layout {layout}: {why}")
