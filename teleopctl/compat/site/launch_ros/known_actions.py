"""Constructor arguments of the actions in ``launch_ros`` for steps of launch files."""

from __future__ import annotations

from typing import Any

from launch.frontend.known import is_known_as, text
from launch.frontend.known_actions import command_line, process, timer
from launch.frontend.type_utils import get_data_type_from_identifier

from teleopctl import launch as model
from teleopctl.launch import (
    ParameterEntry,
    ParameterFileEntry,
    ParameterTree,
    ProcessPart,
    Template,
)

from . import descriptions
from .actions import (
    Node,
    PushROSNamespace,
    ROSTimer,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
    SetROSLogDir,
    SetUseSimTime,
)

# Any, in what follows: constructor arguments, which differ by class.
is_known_as("ros_timer", model.RosTimer, ROSTimer)(timer)


@is_known_as("node", model.Node, Node)
def _node(action: ProcessPart) -> dict[str, Any]:
    node = action.node
    assert node is not None
    words: dict[str, Any] = {"executable": text(node.executable), **process(action)}
    for name, value in (
        ("package", node.package),
        ("name", node.name),
        ("namespace", node.namespace),
        ("exec_name", action.process_name),
    ):
        if value is not None:
            words[name] = text(value)
    if node.parameters:
        words["parameters"] = [_parameter(entry) for entry in node.parameters]
    if node.remaps:
        words["remappings"] = [(text(source), text(target)) for source, target in node.remaps]
    if node.ros_arguments is not None:
        words["ros_arguments"] = command_line(node.ros_arguments)
    if action.arguments is not None:
        words["arguments"] = command_line(action.arguments)
    return words


def _parameter(entry: ParameterEntry | ParameterFileEntry) -> Any:
    if isinstance(entry, ParameterFileEntry):
        allows = entry.allow_substs
        return descriptions.ParameterFile(
            text(entry.path), allow_substs=allows if isinstance(allows, bool) else text(allows)
        )
    return {tuple(text(entry.name)): _value(entry)}


def _value(entry: ParameterEntry) -> descriptions.ParameterValue:
    kind = None if entry.type_name is None else get_data_type_from_identifier(entry.type_name)
    return descriptions.ParameterValue(_tree(entry.value), value_type=kind)


# Any: a value, or substitutions.
def _tree(value: ParameterTree) -> Any:
    if isinstance(value, list):
        return [_tree(item) for item in value]
    return text(value) if isinstance(value, Template) else value


@is_known_as("push_ros_namespace", model.PushNamespace, PushROSNamespace)
def _namespace(action: model.PushNamespace) -> dict[str, Any]:
    return {"namespace": text(action.namespace)}


@is_known_as("set_parameter", model.SetParameter, SetParameter)
def _set_parameter(action: model.SetParameter) -> dict[str, Any]:
    parameter = action.parameter
    typed = parameter.type_name is not None
    value = _value(parameter) if typed else _tree(parameter.value)
    return {"name": text(parameter.name), "value": value}


@is_known_as("set_parameters_from_file", model.SetParametersFromFile, SetParametersFromFile)
def _from_file(action: model.SetParametersFromFile) -> dict[str, Any]:
    return {"filename": text(action.file)}


@is_known_as("set_remap", model.SetRemap, SetRemap)
def _remap(action: model.SetRemap) -> dict[str, Any]:
    return {"src": text(action.source), "dst": text(action.target)}


@is_known_as("set_use_sim_time", model.SetUseSimTime, SetUseSimTime)
def _sim_time(action: model.SetUseSimTime) -> dict[str, Any]:
    return {"value": text(action.value)}


@is_known_as("set_ros_log_dir", model.SetRosLogDirectory, SetROSLogDir)
def _log_dir(action: model.SetRosLogDirectory) -> dict[str, Any]:
    return {"new_log_dir": text(action.folder)}
