"""Recording of a whole launch into a bag (launch argument ``record``)."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from teleopctl.base.typed import Mapping
from teleopctl.errors import RefusedError
from teleopctl.launch.arguments import argument_names
from teleopctl.launch.model.plan import LaunchPlan, ProcessPlan
from teleopctl.launch.model.records import replace

RECORDER = "rosbag2_recorder"
"""Name of the recorder's node."""
ARGUMENT = "record"
"""Launch argument of every launch file, unless the file declares an argument of that name."""

# Environment variable with the file and arguments of the launch, which the recorder stores.
_LAUNCH_VARIABLE = "TELEOPCTL_LAUNCH_OF_RECORDING"
# Writing the recorder's cache to a slow disk takes longer than the shutdown of other nodes.
_FINISHED_WITHIN_S = 30.0


def bag_folder(file: Path, arguments: dict[str, str]) -> Path | None:
    """Remove ``record`` from the launch arguments; return the folder for the bag, or None.

    ``true`` stands for a folder in the working directory, named after the launch file and the time;
    ``false`` for no recording. Any other value is the path of the folder.

    Args:
        file: Path of the launch file.
        arguments: Launch arguments from the command line, by name.

    Returns:
        The folder; None without recording, or if the launch file declares an argument ``record``.

    Raises:
        RefusedError: The folder already exists.
    """
    if ARGUMENT not in arguments or ARGUMENT in argument_names(file):
        return None
    value = arguments.pop(ARGUMENT)
    if value.lower() in ("false", "0", ""):
        return None
    if value.lower() in ("true", "1"):
        stem = file.stem.removesuffix(".launch")
        value = time.strftime(f"{stem}_%Y_%m_%d-%H_%M_%S")
    folder = Path(value).absolute()
    if folder.exists():
        raise RefusedError(
            f"Output folder '{folder}' already exists.", hint="Name another one, or remove it."
        )
    return folder


def with_recorder(
    plan: LaunchPlan, folder: Path, file: Path, arguments: Mapping[str, str]
) -> LaunchPlan:
    """Return a launch plan with a recorder added, which runs from before the start to the end.

    Args:
        plan: Plan of the launch.
        folder: Folder of the bag to record.
        file: Path of the launch file, which the recorder stores in the bag.
        arguments: Launch arguments from the command line, which are stored as well.
    """
    about = json.dumps({"file": str(file.absolute()), "arguments": dict(arguments)})
    recorder = ProcessPlan(
        name="recorder",
        command=[
            *(sys.executable, "-P", "-m", "teleopctl.nodes"),
            *("--builtin", "rosbag2_transport", "recorder", "--ros-args"),
            *("-p", f"storage.uri:={json.dumps(str(folder))}"),
            *("-p", "record.from_first_message:=true"),
        ],
        environment={_LAUNCH_VARIABLE: about},
        is_node=True,
        node_name=f"/{RECORDER}",
        accompanies=True,
        sigterm_timeout=_FINISHED_WITHIN_S,
    )
    start = replace(plan.start, processes=[*plan.processes, recorder])
    return replace(plan, start=start)
