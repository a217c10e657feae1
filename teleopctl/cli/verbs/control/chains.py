"""``control view_controller_chains``."""

import tempfile
from collections.abc import Iterable
from pathlib import Path

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.listing import out_files
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.session import (
    DEFAULT_MANAGER,
    ManagerName,
    RosArgs,
    manager_client,
)
from teleopctl.diagram import Diagram, DiagramBox, joined, to_dot, to_svg, write_files

# The name that ros2 control gives its PDF.
_NAME = "controller_diagram"


def view_controller_chains(
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="Name of the files, without their endings; otherwise in the folder for temporary "
            "files.",
            metavar="FILE",
        ),
    ] = None,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Draw controllers and their interfaces.

    State interfaces stand before a controller, and what it commands behind it: hardware, or the
    reference interfaces of the next controller. Writes a graph for Graphviz, an SVG, and a PDF
    where Graphviz's program dot is installed.
    """
    with manager_client(controller_manager, ros_args) as client:
        diagram = picture(client.list_controllers())
    base = Path(output) if output else Path(tempfile.gettempdir()) / _NAME
    files = write_files(base, to_dot(diagram), to_svg(diagram), console.note)
    out_files(files, as_json=as_json)


# Any: ControllerState of controller_manager_msgs.
def picture(controllers: Iterable[Any]) -> Diagram:
    """Return a diagram of controllers with their state and command interfaces."""
    boxes: dict[str, DiagramBox] = {}
    pairs: list[tuple[str, str]] = []

    def interface(name: str) -> str:
        # A joint's position is both measured and commanded: two boxes, as two interfaces.
        return boxes.setdefault(name, DiagramBox(name, name.partition(" ")[2], "topic")).key

    for controller in controllers:
        key = f"controller {controller.name}"
        text = f"{controller.name}\n{controller.state}"
        boxes[key] = DiagramBox(key, text, "node")
        pairs += [
            (interface(f"state {name}"), key) for name in controller.required_state_interfaces
        ]
        # What it exports is named without the controller, and with it where others use it.
        pairs += [
            (interface(f"command {controller.name}/{name}"), key)
            for name in controller.reference_interfaces
        ]
        pairs += [
            (key, interface(f"state {controller.name}/{name}"))
            for name in controller.exported_state_interfaces
        ]
        pairs += [
            (key, interface(f"command {name}")) for name in controller.required_command_interfaces
        ]
    return joined(list(boxes.values()), pairs)
