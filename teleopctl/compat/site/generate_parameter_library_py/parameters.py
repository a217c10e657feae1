"""``generate_parameter_library_py.parameters``. Classes made of a YAML file with parameters (ours).

A file has one name with the parameters below it::

    my_node:
      rate: {type: double, default_value: 10.0, validation: {gt<>: [0.0]}}
      joints: {type: string_array, default_value: [a, b]}
      gains:
        __map_joints:
          p: {type: double, default_value: 1.0}

The class ``my_node`` has `Params`, whose attributes are the values (``params.rate``,
``params.gains.get_entry("a").p``), and `ParamListener`, which declares and follows them at a node.
"""

import copy
import importlib
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.clock import Clock
from rclpy.exceptions import InvalidParameterValueException
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time

from generate_parameter_library_py.python_validators import ParameterValidators
from teleopctl.errors import InvalidFileError
from teleopctl.node import ParameterType

__all__ = ["ParamListener", "Params", "Struct", "namespace_of"]

_MAP = "__map_"
_TYPES = {
    "bool": Parameter.Type.BOOL,
    "int": Parameter.Type.INTEGER,
    "double": Parameter.Type.DOUBLE,
    "string": Parameter.Type.STRING,
    "bool_array": Parameter.Type.BOOL_ARRAY,
    "int_array": Parameter.Type.INTEGER_ARRAY,
    "double_array": Parameter.Type.DOUBLE_ARRAY,
    "string_array": Parameter.Type.STRING_ARRAY,
}
_RANGES = {"bounds", "lower_bounds", "upper_bounds", "lt", "lt_eq", "gt", "gt_eq"}

# Any, here and below: YAML values, and values of parameters.
_Yaml = Mapping[str, Any]
_Check = tuple[str, Callable[..., str], list[Any]]


class Struct:
    """Values of parameters as attributes; entries of a map are added and returned by name.

    Args:
        content: Part of the YAML file.
    """

    def __init__(self, content: _Yaml) -> None:
        self._entries: _Yaml = next((v for k, v in content.items() if k.startswith(_MAP)), {})
        for name, part in content.items():
            if name.startswith(_MAP):
                continue
            setattr(self, name, part.get("default_value") if "type" in part else Struct(part))

    def add_entry(self, name: str) -> "Struct":
        """Return an entry of the map by name, added if it is not there."""
        if not hasattr(self, name):
            setattr(self, name, Struct(self._entries))
        entry: Struct = self.get_entry(name)
        return entry

    def get_entry(self, name: str) -> Any:
        """Return an entry of the map by name.

        Raises:
            AttributeError: There is none of that name.
        """
        return getattr(self, name)


class Params(Struct):
    """Values of all parameters of a file.

    Attributes:
        content: Parameters of the YAML file, a class attribute.
        stamp_: Time of the last change.
    """

    content: _Yaml

    def __init__(self) -> None:
        super().__init__(self.content)
        self.stamp_: Time | None = Time()


class ParamListener:
    """Declares parameters at a node, and follows their changes.

    Args:
        node: Node of the parameters.
        prefix: Text before each name.

    Raises:
        InvalidParameterValueException: An override is invalid.
        ParameterUninitializedException: A parameter without a default has no override.
    """

    name: str
    params: type[Params]
    validators: dict[str, Any]

    def __init__(self, node: Node, prefix: str = "") -> None:
        self.prefix_ = prefix
        self.params_ = self.params()
        self.node_ = node
        self.logger_ = get_logger(f"{self.name}.{prefix}")
        self.user_callback: Callable[[Params], object] | None = None
        self.clock_ = Clock()
        self.declare_params()
        node.add_on_set_parameters_callback(self.update)

    def get_params(self) -> Params:
        """Return a copy of the values."""
        return copy.deepcopy(self.params_)

    def is_old(self, other_param: Params) -> bool:
        """Return whether values have changed since a copy was made."""
        return self.params_.stamp_ != other_param.stamp_

    def set_user_callback(self, callback: Callable[[Params], object]) -> None:
        """Set a function to call with the values after each change."""
        self.user_callback = callback

    def clear_user_callback(self) -> None:
        """Unset the function of `set_user_callback`."""
        self.user_callback = None

    def declare_params(self) -> None:
        """Declare the parameters, and take their values."""
        updated = self.get_params()
        for struct, name, full_name, content in self._walk(updated):
            self._declare(struct, name, full_name, content)
        self.update_internal_params(updated)

    def refresh_dynamic_parameters(self) -> None:
        """Declare the parameters of entries that have been added to maps."""
        self.declare_params()

    def update_internal_params(self, updated_params: Params) -> None:
        """Replace the values."""
        self.params_ = updated_params

    def unpack_parameter_dict(
        self, namespace: str, parameter_dict: Mapping[str, Any]
    ) -> list[Parameter]:
        """Return nested values as parameters, with their names joined by dots."""
        found = []
        for name, value in parameter_dict.items():
            if isinstance(value, dict):
                found += self.unpack_parameter_dict(f"{namespace}{name}.", value)
            else:
                found.append(Parameter(f"{namespace}{name}", value=value))
        return found

    def set_params_from_dict(self, param_dict: Mapping[str, Any]) -> None:
        """Take values of a nested mapping, without setting the node's parameters."""
        self.update(self.unpack_parameter_dict("", param_dict))

    def update(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take new values of parameters, or reject them."""
        updated = self.get_params()
        given = {parameter.name: parameter for parameter in parameters}
        for struct, name, full_name, content in self._walk(updated):
            if (parameter := given.get(full_name)) is None:
                continue
            if problem := self._problem(parameter, content):
                return SetParametersResult(successful=False, reason=problem)
            setattr(struct, name, parameter.value)
        updated.stamp_ = self.clock_.now()
        self.update_internal_params(updated)
        if self.user_callback is not None:
            self.user_callback(self.get_params())
        return SetParametersResult(successful=True)

    def _walk(self, params: Params) -> Iterator[tuple[Struct, str, str, _Yaml]]:
        """Yield struct, attribute, full name and description of each parameter.

        Entries of maps come after all other parameters, whose values name them; entries are added
        on the way.
        """
        maps: list[tuple[Struct, _Yaml, str]] = [(params, self.params.content, self.prefix_)]
        for struct, content, prefix in maps:
            for name, part in content.items():
                full_name = prefix + name
                if name.startswith(_MAP):
                    continue
                if "type" in part:
                    if part["type"] != "none":
                        yield struct, name, full_name, part
                else:
                    maps.append((getattr(struct, name), part, f"{full_name}."))
        while maps:
            struct, content, prefix = maps.pop(0)
            for name, part in content.items():
                if name.startswith(_MAP):
                    for entry in self._entries(params, struct, name.removeprefix(_MAP)):
                        maps.append((struct.add_entry(entry), part, f"{prefix}{entry}."))
                        yield from self._plain(*maps[-1], maps)

    def _plain(
        self, struct: Struct, content: _Yaml, prefix: str, maps: list[tuple[Struct, _Yaml, str]]
    ) -> Iterator[tuple[Struct, str, str, _Yaml]]:
        """Yield the parameters of an entry of a map, and note the structs below it."""
        for name, part in content.items():
            if name.startswith(_MAP):
                continue
            if "type" in part:
                yield struct, name, prefix + name, part
            else:
                maps.append((getattr(struct, name), part, f"{prefix}{name}."))
                yield from self._plain(*maps[-1], maps)

    def _entries(self, params: Params, struct: Struct, name: str) -> list[str]:
        """Return the names of a map's entries: the value of a parameter beside it, or of all."""
        for owner in (struct, params):
            value = getattr(owner, name, None)
            if isinstance(value, list | tuple):
                return list(value)
        raise InvalidFileError(f"{self.name}: the map {_MAP}{name} has no parameter '{name}'")

    def _declare(self, struct: Struct, name: str, full_name: str, content: _Yaml) -> None:
        kind = _type_of(content, full_name)
        if not self.node_.has_parameter(full_name):
            default = content.get("default_value")
            self.node_.declare_parameter(
                full_name,
                kind if default is None else Parameter(full_name, kind, _as(kind, default)).value,
                self._descriptor(content, kind),
            )
        parameter = self.node_.get_parameter(full_name)
        if problem := self._problem(parameter, content):
            raise InvalidParameterValueException(
                full_name, parameter.value, f"Invalid value set during initialization: {problem}"
            )
        setattr(struct, name, parameter.value)

    def _checks(self, content: _Yaml) -> Iterator[_Check]:
        for given, arguments in (content.get("validation") or {}).items():
            name = given.removesuffix("<>")
            listed = [] if arguments is None else arguments
            listed = listed if isinstance(listed, list) else [listed]
            _, separator, custom = name.rpartition("::")
            if separator and custom in self.validators:
                yield custom, self.validators[custom], listed
            else:
                yield custom, getattr(ParameterValidators, custom), listed

    def _problem(self, parameter: Parameter, content: _Yaml) -> str:
        """Return why a value is invalid; empty if it is valid."""
        for _, check, arguments in self._checks(content):
            if problem := check(parameter, *arguments):
                return problem
        return ""

    def _descriptor(self, content: _Yaml, kind: ParameterType) -> ParameterDescriptor:
        described = ParameterDescriptor(
            description=content.get("description", ""),
            read_only=bool(content.get("read_only", False)),
            additional_constraints=content.get("additional_constraints", ""),
        )
        is_double = kind is Parameter.Type.DOUBLE
        if not is_double and kind is not Parameter.Type.INTEGER:
            return described
        step = sys.float_info.epsilon if is_double else 1
        lower: Any = None
        upper: Any = None
        for name, _, arguments in self._checks(content):
            if name not in _RANGES or not arguments:
                continue
            if name == "bounds":
                lower, upper = arguments
            elif name in ("gt", "gt_eq", "lower_bounds"):
                lower = arguments[0] + (step if name == "gt" else 0)
            else:
                upper = arguments[0] - (step if name == "lt" else 0)
        if lower is None and upper is None:
            return described
        if is_double:
            described.floating_point_range = [
                FloatingPointRange(
                    from_value=-sys.float_info.max if lower is None else float(lower),
                    to_value=sys.float_info.max if upper is None else float(upper),
                )
            ]
        else:
            described.integer_range = [
                IntegerRange(
                    from_value=-(2**63) if lower is None else int(lower),
                    to_value=2**63 - 1 if upper is None else int(upper),
                )
            ]
        return described


def _type_of(content: _Yaml, name: str) -> ParameterType:
    kind = str(content["type"]).partition("_fixed_")[0]
    if kind not in _TYPES:
        raise InvalidFileError(
            f"parameter '{name}' has the unknown type '{content['type']}'",
            hint=f"There are {', '.join(_TYPES)}.",
        )
    return _TYPES[kind]


def _as(kind: ParameterType, value: Any) -> Any:
    """Return a YAML value as its type has it: an integer for a double is one."""
    if kind is Parameter.Type.DOUBLE:
        return float(value)
    if kind is Parameter.Type.DOUBLE_ARRAY:
        return [float(each) for each in value]
    return value


def namespace_of(yaml_file: str | Path, validators_module: str = "") -> tuple[str, type]:
    """Return name and class of a file's parameters.

    Args:
        yaml_file: File with one name, and the parameters below it.
        validators_module: Module with the ``custom_validators`` of the file, or empty.

    Raises:
        InvalidFileError: The file is none of parameters.
    """
    path = Path(yaml_file)
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise InvalidFileError(f"{path}: {error}") from error
    if not isinstance(document, dict) or len(document) != 1:
        raise InvalidFileError(
            f"{path} is no file of parameters: one name with the parameters below it is expected"
        )
    ((name, content),) = document.items()
    module = vars(importlib.import_module(validators_module)) if validators_module else {}
    params = type("Params", (Params,), {"content": content or {}})
    listener = type(
        "ParamListener", (ParamListener,), {"name": name, "params": params, "validators": module}
    )
    return name, type(name, (), {"Params": params, "ParamListener": listener})
