"""Parameters of a node, with the rules and callbacks that check changes."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from teleopctl.base.typed import TYPE_CHECKING, TypeAlias
from teleopctl.interfaces import AllowableParameterValue, get_message, parameter_value_to_python
from teleopctl.node.values.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from teleopctl.node.values.parameter import Parameter, ParameterType

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult


PARAM_REL_TOL = 1e-6
"""Relative error within which a float is at an end or a step of its range, as in rclpy."""


def range_problem(name: str, value: object, descriptor: ParameterDescriptor) -> str | None:
    """Return why a value violates its descriptor's range or step; None if it does not."""
    ranges = descriptor.integer_range if isinstance(value, int) else descriptor.floating_point_range
    if isinstance(value, bool) or not isinstance(value, int | float) or not ranges:
        return None
    allowed = ranges[0]
    tolerance = PARAM_REL_TOL if isinstance(value, float) else 0.0
    if value < allowed.from_value or value > allowed.to_value:
        # With rounding errors, a value may exceed the ends themselves.
        ends = (allowed.from_value, allowed.to_value)
        if not any(math.isclose(value, end, rel_tol=tolerance) for end in ends):
            return (
                f"Parameter {name} out of range. Min: {allowed.from_value}, "
                f"Max: {allowed.to_value}, value: {value}"
            )
    if allowed.step:
        steps = (value - allowed.from_value) / allowed.step
        nearest = allowed.from_value + round(steps) * allowed.step
        if not any(
            math.isclose(value, good, rel_tol=tolerance) for good in (allowed.to_value, nearest)
        ):
            return f"The parameter value for {name} is not a valid step. Step: {allowed.step}"
    return None


def is_listed(name: str, prefixes: Sequence[str], depth: int) -> bool:
    """Return whether a ListParameters request with these prefixes and depth selects a name."""
    if not prefixes:
        return depth == 0 or name.count(".") < depth
    for prefix in prefixes:
        if name == prefix:
            return True
        if name.startswith(f"{prefix}."):
            below = name[len(prefix) + 1 :]
            if depth == 0 or below.count(".") < depth:
                return True
    return False


# Called with the parameters to set; returns whether they are accepted.
OnSetCallback: TypeAlias = "Callable[[list[Parameter]], SetParametersResult]"
PreSetCallback = Callable[[list[Parameter]], list[Parameter]]
PostSetCallback = Callable[[list[Parameter]], None]
# Called with the new, changed and deleted parameters.
ChangeListener = Callable[[list[Parameter], list[Parameter], list[Parameter]], None]


def result(successful: bool, reason: str = "") -> SetParametersResult:
    """Return a new ``rcl_interfaces/msg/SetParametersResult`` message."""
    message: type[SetParametersResult] = get_message("rcl_interfaces/msg/SetParametersResult")
    return message(successful=successful, reason=reason)


def _invalid_answer(callback: Callable[..., object], answer: object, expected: str) -> str:
    """Log that a callback returned a value of the wrong type, and return the reason."""
    import logging  # takes longer to import than some commands run

    name = getattr(callback, "__qualname__", type(callback).__qualname__)
    reason = "Callback returned an invalid type"
    logging.getLogger(__name__).warning(
        "%s: %s: %s, not a %s", name, reason, type(answer).__name__, expected
    )
    return reason


class ParameterStore(Mapping[str, Parameter]):
    """Declared parameters of a node, with the rules and callbacks that check changes.

    As a mapping it has the declared parameters by name, which programs read as rclpy's
    ``Node._parameters``.

    Args:
        overrides: Parameters from the command line and from files, by name; they replace the
            defaults of declarations.
        allow_undeclared: Whether undeclared parameters can be set and read.
        on_change: Called with the new, changed and deleted parameters after every change.
    """

    def __init__(
        self,
        overrides: Mapping[str, Parameter],
        *,
        allow_undeclared: bool,
        on_change: ChangeListener,
    ) -> None:
        self.overrides = dict(overrides)
        self.allow_undeclared = allow_undeclared
        self.on_set_callbacks: list[OnSetCallback] = []
        self.pre_set_callbacks: list[PreSetCallback] = []
        self.post_set_callbacks: list[PostSetCallback] = []
        self._on_change = on_change
        self._lock = threading.RLock()
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, ParameterDescriptor] = {}

    def __getitem__(self, name: str) -> Parameter:
        return self._parameters[name]

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._parameters))

    def __len__(self) -> int:
        return len(self._parameters)

    def names(self) -> list[str]:
        """Return the names of the declared parameters, in the order of their declaration."""
        return list(self._parameters)

    def list_names(self, prefixes: Sequence[str], depth: int) -> tuple[list[str], list[str]]:
        """Return sorted names below prefixes, down to a depth, and the sorted parents of these.

        Args:
            prefixes: Prefixes of the names; empty for all parameters.
            depth: Largest number of name parts below a prefix; 0 is unlimited.
        """
        names = sorted(name for name in self._parameters if is_listed(name, prefixes, depth))
        return names, sorted({name.rpartition(".")[0] for name in names if "." in name})

    def check_declared(self, parameters: Iterable[Parameter]) -> None:
        """Raise unless all parameters are declared or undeclared ones are allowed.

        Raises:
            ParameterNotDeclaredException: Some parameters are undeclared, which is not allowed.
        """
        unknown = [p.name for p in parameters if p.name not in self._parameters]
        if unknown and not self.allow_undeclared:
            raise ParameterNotDeclaredException(unknown)

    def has(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return name in self._parameters

    def declare(
        self,
        name: str,
        value: AllowableParameterValue | ParameterType,
        descriptor: ParameterDescriptor | None,
        ignore_override: bool,
    ) -> Parameter:
        """Declare a parameter and return it; see ``Node.declare_parameter``."""
        if not name:
            raise InvalidParameterException(name)
        with self._lock:
            if name in self._parameters:
                raise ParameterAlreadyDeclaredException(name)
            described = get_message("rcl_interfaces/msg/ParameterDescriptor")
            from copy import copy

            # The program may use one descriptor for several parameters.
            own = described() if descriptor is None else copy(descriptor)
            if not isinstance(own, described):
                raise TypeError(f"a descriptor is expected, not {type(descriptor).__name__}")
            own.name = name
            if isinstance(value, get_message("rcl_interfaces/msg/ParameterValue")):
                value = parameter_value_to_python(value)
            if isinstance(value, ParameterType):
                if value == ParameterType.NOT_SET or own.dynamic_typing:
                    raise ValueError(
                        f"parameter '{name}' cannot be declared with the type {value.name} "
                        f"and dynamic_typing {own.dynamic_typing}"
                    )
                own.type = int(value)
                default = Parameter(name)
            else:
                default = Parameter(name, value=value)
                if value is None and descriptor is None:
                    import warnings

                    warnings.warn(
                        f"parameter '{name}' is declared by its name only, which is deprecated: "
                        "give a default value, a type, or a descriptor with dynamic_typing",
                        stacklevel=4,
                    )
                    own.dynamic_typing = True
                elif value is None and not own.dynamic_typing:
                    raise ValueError(
                        f"parameter '{name}' is statically typed, so that it needs a default value "
                        "or a type"
                    )
                if not own.dynamic_typing and value is not None:
                    own.type = int(default.type_)
            parameter = default
            if not ignore_override and name in self.overrides:
                parameter = self._override_in_type(self.overrides[name], own)
            self._descriptors[name] = own
            problem = self._set_problem(parameter, own, declaring=True)
            if problem is None and parameter.type_ != ParameterType.NOT_SET:
                problem = self._callback_refusal([parameter])
            if problem is not None:
                del self._descriptors[name]
                if not own.dynamic_typing and own.type not in (
                    ParameterType.NOT_SET,
                    parameter.type_,
                ):
                    raise InvalidParameterTypeException(parameter, ParameterType(own.type).name)
                raise InvalidParameterValueException(name, parameter.value, problem)
            self._parameters[name] = parameter
        if parameter.type_ != ParameterType.NOT_SET:
            self._on_change([parameter], [], [])
        return parameter

    @staticmethod
    def _override_in_type(override: Parameter, descriptor: ParameterDescriptor) -> Parameter:
        """Return an override, an empty list in the declared array type."""
        declared = ParameterType(descriptor.type)
        empty = isinstance(override.value, list) and not override.value
        if empty and declared > ParameterType.BYTE_ARRAY:
            return Parameter(override.name, declared, [])
        return override

    def undeclare(self, name: str) -> None:
        """Undeclare a parameter by name; raise if it is undeclared or read-only.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared.
            ParameterImmutableException: The parameter is read-only.
        """
        with self._lock:
            if name not in self._parameters:
                raise ParameterNotDeclaredException(name)
            if self._descriptors[name].read_only:
                raise ParameterImmutableException(name)
            parameter = self._parameters.pop(name)
            del self._descriptors[name]
        self._on_change([], [], [parameter])

    def readable(self, name: str) -> Parameter:
        """Return a parameter; raise if statically typed but unset, or undeclared unless allowed.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared, which is not allowed.
            ParameterUninitializedException: The parameter is statically typed and has no value yet.
        """
        parameter = self._parameters.get(name)
        if parameter is None:
            if self.allow_undeclared:
                return Parameter(name)
            raise ParameterNotDeclaredException(name)
        if self.is_uninitialized(name):
            raise ParameterUninitializedException(name)
        return parameter

    def is_uninitialized(self, name: str) -> bool:
        """Return whether a declared parameter has a static type and no value yet."""
        return (
            self._parameters[name].type_ == ParameterType.NOT_SET
            and not self._descriptors[name].dynamic_typing
        )

    def find(self, name: str) -> Parameter | None:
        """Return a declared parameter, initialized or not; None if it is undeclared."""
        return self._parameters.get(name)

    def by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by their names without the prefix."""
        start = f"{prefix}." if prefix else ""
        return {
            name[len(start) :]: parameter
            for name, parameter in self._parameters.items()
            if name.startswith(start)
        }

    def descriptor(self, name: str) -> ParameterDescriptor:
        """Return a parameter's descriptor; if undeclared raise, or return an empty one if allowed.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared, which is not allowed.
        """
        if name not in self._parameters:
            if not self.allow_undeclared:
                raise ParameterNotDeclaredException(name)
            message: type[ParameterDescriptor] = get_message(
                "rcl_interfaces/msg/ParameterDescriptor"
            )
            return message()
        return self._descriptors[name]

    def describe(
        self, name: str, descriptor: ParameterDescriptor, alternative: Parameter | None
    ) -> Parameter:
        """Replace a descriptor; return the parameter, or the alternative if only that fits."""
        with self._lock:
            if name not in self._parameters:
                raise ParameterNotDeclaredException(name)
            if self._descriptors[name].read_only:
                raise ParameterImmutableException(name)
            parameter = self._parameters[name]
            descriptor.name = name
            descriptor.type = int(parameter.type_)
            problem = self._set_problem(parameter, descriptor, declaring=True)
            if problem is not None and alternative is not None:
                parameter = alternative
                problem = self._set_problem(parameter, descriptor, declaring=True)
            if problem is not None:
                raise InvalidParameterValueException(name, parameter.value, problem)
            before = self._parameters[name]
            self._descriptors[name] = descriptor
            self._parameters[name] = parameter
        if parameter is not before:
            self._on_change([], [parameter], [])
        return parameter

    def set_atomically(
        self,
        parameters: Sequence[Parameter],
        check: Callable[[Iterable[Parameter]], None] = lambda _: None,
    ) -> SetParametersResult:
        """Set all of the parameters, or none if one is rejected; return a ``SetParametersResult``.

        Args:
            parameters: Parameters to set.
            check: Called with the list that the pre-set callbacks returned; raises to reject it.
        """
        wanted = list(parameters)
        for pre_set in reversed(self.pre_set_callbacks):
            wanted = pre_set(wanted)
            if not isinstance(wanted, Sequence):
                return result(False, _invalid_answer(pre_set, wanted, "list of parameters"))
        if parameters and not wanted:
            return result(False, "a pre-set callback removed all parameters")
        check(wanted)
        with self._lock:
            problem = self._first_problem(wanted) or self._callback_refusal(wanted)
            if problem is not None:
                return result(False, problem)
            new, changed, deleted = self._apply(wanted)
        self._on_change(new, changed, deleted)
        for post_set in self.post_set_callbacks:
            post_set(wanted)
        return result(True)

    def _first_problem(self, parameters: Iterable[Parameter]) -> str | None:
        for parameter in parameters:
            descriptor = self._descriptors.get(parameter.name)
            if descriptor is None:
                if not self.allow_undeclared:
                    return f"Parameter {parameter.name} was not declared"
            elif problem := self._set_problem(parameter, descriptor):
                return problem
        return None

    @staticmethod
    def _set_problem(
        parameter: Parameter, descriptor: ParameterDescriptor, *, declaring: bool = False
    ) -> str | None:
        """Return why a value cannot be set; None if it can."""
        if descriptor.read_only and not declaring:
            return f"Trying to set a read-only parameter: {parameter.name}."
        if parameter.type_ == ParameterType.NOT_SET:
            if declaring or descriptor.dynamic_typing:
                return None
            return "Static parameter cannot be undeclared"
        if (
            not descriptor.dynamic_typing
            and descriptor.type != ParameterType.NOT_SET
            and parameter.type_ != descriptor.type
        ):
            return (
                "Wrong parameter type, expected "
                f"'Type.{ParameterType(descriptor.type).name}' got "
                f"'Type.{parameter.type_.name}'"
            )
        return range_problem(parameter.name, parameter.value, descriptor)

    def _callback_refusal(self, parameters: list[Parameter]) -> str | None:
        """Return the reason of the first callback that rejects; None if all accept."""
        for callback in tuple(self.on_set_callbacks):
            answer = callback(parameters)
            # Such as a callback without a return statement; as in rclpy, a rejection.
            if not isinstance(answer, get_message("rcl_interfaces/msg/SetParametersResult")):
                return _invalid_answer(callback, answer, "SetParametersResult")
            if not answer.successful:
                return answer.reason or "rejected by a callback"
        return None

    def _apply(
        self, parameters: Iterable[Parameter]
    ) -> tuple[list[Parameter], list[Parameter], list[Parameter]]:
        new: list[Parameter] = []
        changed: list[Parameter] = []
        deleted: list[Parameter] = []
        for parameter in parameters:
            before = self._parameters.get(parameter.name)
            if parameter.type_ == ParameterType.NOT_SET:
                if before is not None:
                    deleted.append(self._parameters.pop(parameter.name))
                    self._descriptors.pop(parameter.name, None)
                continue
            if parameter.name not in self._descriptors:
                self._descriptors[parameter.name] = get_message(
                    "rcl_interfaces/msg/ParameterDescriptor"
                )(name=parameter.name, type=int(parameter.type_), dynamic_typing=True)
            unset = before is None or before.type_ == ParameterType.NOT_SET
            (new if unset else changed).append(parameter)
            self._parameters[parameter.name] = parameter
        return new, changed, deleted
