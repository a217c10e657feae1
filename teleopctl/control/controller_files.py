"""Parameters of controllers that a controller manager needs before it loads them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidFileError, did_you_mean
from teleopctl.node import (
    ParameterFile,
    place_in_file,
    read_parameter_file,
    read_parameter_lines,
)

# Any: a parameter has one of nine types, which depends on the file.

# Parameters of the controller manager, below the controller's name, that a file may set.
_FROM_FILES = ("type", "fallback_controllers")
MANAGER_PARAMETERS = frozenset((*_FROM_FILES, "params_file", "node_options_args"))
"""Parameters below a controller's name that are the controller manager's own."""


# Parameters of ros2_controllers that no controller needs here, and why.
_RETIRED = tuple(
    (re.compile(rf"{name}\Z"), why)
    for name, why in (
        ("state_publish_rate", "ros2_controllers have dropped it: each update publishes the state"),
        (
            r"gains\..+\.(angle_wraparound|normalize_error)",
            "ros2_controllers have dropped it: continuous joints of the description wrap around",
        ),
        ("(front|rear)_wheels_radius", "steered wheels need no radius"),
    )
)


def controller_load_parameters(
    controller: str, manager: str, files: Sequence[str]
) -> dict[str, Any]:
    """Return a controller's ``type``, ``fallback_controllers`` and ``params_file`` paths as a dict.

    Args:
        controller: Name of the controller.
        manager: Full name of the manager; its namespace is that of the controller, too.
        files: Paths of parameter files; later files have precedence.

    Returns:
        Values by parameter name, without the controller's name: ``params_file``, and parameters
        from the controller's own section or the manager's.

    Raises:
        InvalidFileError: A file is missing, is no parameter file, or names the controller only
            outside of its namespace.
    """
    if not files:
        return {}
    values: dict[str, Any] = {}
    for file in files:
        if not Path(file).is_file():
            raise InvalidFileError(f"Controller parameter file : {file} does not exist")
        values.update(_values(read_parameter_file(Path(file)), controller, manager))
    settings: dict[str, Any] = {"params_file": [str(Path(file).resolve()) for file in files]}
    settings.update((name, values[name]) for name in _FROM_FILES if values.get(name))
    return settings


# Least similarity of names, from 0 to 1, for which one is suggested in place of the other. All
# types have words in common, so difflib's 0.6 alone suggests types of another purpose.
_SIMILAR_TYPE, _LIKE_CLASS = 0.8, 0.5
_SIMILAR_CLASS = 0.75
_LAST_WORD = re.compile("(Controller|Broadcaster)$")


def similar_types(type_name: str, known: Iterable[str]) -> list[str]:
    """Return up to three controller types that are spelled like one, the most similar first.

    Types of other packages count by the names of their classes:
    ``ur_controllers/ScaledJointTrajectoryController`` is similar to
    ``joint_trajectory_controller/JointTrajectoryController``.

    Args:
        type_name: Type to compare with.
        known: Types to choose from.
    """
    from difflib import SequenceMatcher

    whole, of_class = SequenceMatcher(b=type_name), SequenceMatcher(b=_purpose(type_name))
    found = []
    for each in known:
        whole.set_seq1(each)
        of_class.set_seq1(_purpose(each))
        ratios = whole.ratio(), of_class.ratio()
        is_misspelled = ratios[0] >= _SIMILAR_TYPE and ratios[1] >= _LIKE_CLASS
        if is_misspelled or ratios[1] >= _SIMILAR_CLASS:
            found.append((-max(ratios), -ratios[0], each))
    return [each for *_, each in sorted(found)[:3]]


def _purpose(type_name: str) -> str:
    return _LAST_WORD.sub("", type_name.rpartition("/")[2])


def parameter_place(controller: str, manager: str, files: Sequence[str], parameter: str) -> str:
    """Return file and line that set a controller's parameter, as ``FILE:LINE``; empty for none.

    Args:
        controller: Name of the controller.
        manager: Full name of the manager; its namespace is that of the controller, too.
        files: Paths of parameter files; later files have precedence.
        parameter: Dotted name of the parameter, without the controller's name.
    """
    for file in reversed(files):
        try:
            lines = _values(read_parameter_lines(Path(file)), controller, manager)
        except InvalidFileError:
            continue
        if parameter in lines:
            return place_in_file(file, lines[parameter])
    return ""


def unread_parameter_sentence(parameter: str, place: str, known: Iterable[str]) -> str:
    """Return a sentence about a parameter without effect: its place, and why or the nearest name.

    Args:
        parameter: Dotted name of the parameter.
        place: Place as `parameter_place` returns it.
        known: Names of the parameters that the controller reads.
    """
    subject = f"Parameter '{parameter}'{f' ({place})' if place else ''}"
    for pattern, why in _RETIRED:
        if pattern.match(parameter):
            return f"{subject} has no effect: {why}."
    near = did_you_mean(parameter, sorted(known), most=1)
    return f"{subject} is unknown and has no effect.{f' {near}' if near else ''}"


def _values(file: ParameterFile, controller: str, manager: str) -> dict[str, Any]:
    namespace = manager.rpartition("/")[0]
    own = file.for_node(f"{namespace}/{controller}")
    if not own and namespace and file.for_node(f"/{controller}"):
        raise InvalidFileError(
            f"Missing namespace : {namespace} or wildcard in parameter file for controller : "
            f"{controller}"
        )
    prefix = f"{controller}."
    of_manager = {
        name.removeprefix(prefix): value
        for name, value in file.for_node(manager).items()
        if name.startswith(prefix)
    }
    return {**of_manager, **own}
