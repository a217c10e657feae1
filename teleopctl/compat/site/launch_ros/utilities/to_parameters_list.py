"""``launch_ros.utilities.to_parameters_list``."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from launch.launch_context import LaunchContext
from rclpy.parameter import Parameter

from teleopctl.base import ros_yaml

from ..parameters_type import EvaluatedParameters
from .evaluate_parameters import evaluate_parameter_dict
from .normalize_parameters import normalize_parameter_dict


def is_node_name_matched(node_name: str, node_fqn: str) -> bool:
    """Return whether a key of a parameter file, with its ``*`` and ``**``, matches a node."""
    pattern = re.sub(r"/\*(\*)?", lambda match: r"(/\w+)" + (match[1] or ""), node_name)
    return re.fullmatch(pattern, node_fqn) is not None


def to_parameters_list(
    context: LaunchContext,
    node_name: str,
    namespace: str,
    evaluated_parameters: EvaluatedParameters,
) -> list[Parameter]:
    """Return parameters as a list of `rclpy.parameter.Parameter`.

    Args:
        context: Context for the substitutions.
        node_name: The node; sections of a file for other nodes are ignored.
        namespace: Its namespace.
        evaluated_parameters: Return value of `evaluate_parameters`.

    Raises:
        RuntimeError: A value is none that a parameter can have.
    """
    node = f"/{namespace.strip('/')}/{node_name.lstrip('/')}".replace("//", "/")
    found = []
    for entry in evaluated_parameters:
        given = _of_file(context, entry, node) if isinstance(entry, Path) else entry
        if not isinstance(given, Mapping):
            raise RuntimeError(f"invalid evaluated parameters {given!r}")
        for name, value in given.items():
            # Booleans before integers, which they are in Python.
            kind = next((kind for kind in Parameter.Type if kind.check(value)), None)
            if kind is None:
                raise RuntimeError(f"invalid parameter value {value!r}")
            found.append(Parameter(name, kind, value))
    return found


# Any: see `parameters_type`.
def _of_file(context: LaunchContext, file: Path, node: str) -> Mapping[str, Any]:
    with ros_yaml.faults_of(file):
        document = ros_yaml.safe_load(file.read_text(encoding="utf-8"))
    if not isinstance(document, Mapping):
        return {}
    sections = dict(_sections(document, ""))
    if not sections:
        return evaluate_parameter_dict(context, normalize_parameter_dict(document))
    if node == "/":
        warnings.warn(
            "node name not provided to launch; parameter files will not apply", stacklevel=3
        )
    meant = [of for key, of in sections.items() if key != node and is_node_name_matched(key, node)]
    whole: dict[str, Any] = {}
    for section in (*meant, sections.get(node, {})):
        whole.update(section)
    return evaluate_parameter_dict(context, normalize_parameter_dict(whole))


def _sections(document: Mapping[str, Any], above: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the full node name of each section of a parameter file, and its content."""
    for key, value in document.items():
        if key == "ros__parameters":
            yield above, value
        elif isinstance(value, Mapping):
            yield from _sections(value, f"{above}/{key.lstrip('/')}")
