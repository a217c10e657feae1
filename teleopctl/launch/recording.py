"""Recording of a whole launch into a bag (launch argument ``record``)."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from teleopctl.errors import RefusedError
from teleopctl.launch.arguments import argument_names
from teleopctl.launch.model.plan import LaunchPlan, ProcessPlan

ARGUMENT = "record"
"""The argument that every launch file has, unless it declares one of that name."""

# What the recorder writes into the bag.
_LAUNCH_VARIABLE = "TELEOPCTL_LAUNCH_OF_RECORDING"
_NODE = "rosbag2_recorder"
# Writing what is still in memory to a slow disk takes longer than other nodes' endings.
_FINISHED_WITHIN_S = 30.0


def bag_folder(file: Path, arguments: dict[str, str]) -> Path | None:
    """Remove ``record`` from the launch arguments; return the folder for the bag, or None.

    ``true`` is a folder in the working directory named after the launch file and the time,
    ``false`` none; everything else is the folder.

    Args:
        file: The launch file.
        arguments: What is given on the command line.

    Returns:
        None where nothing is to be recorded, or the file has an argument of that name itself.

    Raises:
        RefusedError: There is something at that place already.
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
        plan: What is to be started.
        folder: Where the bag is to be.
        file: The launch file, whose text and arguments the bag is to have.
        arguments: What was given on the command line.
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
        node_name=f"/{_NODE}",
        accompanies=True,
        sigterm_timeout=_FINISHED_WITHIN_S,
    )
    start = replace(plan.start, processes=[*plan.processes, recorder])
    return replace(plan, start=start)
