"""Parameter methods of a node, as rclpy's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Literal, TypeAlias
from teleopctl.interfaces import AllowableParameterValue, get_message, parameter_value_to_python
from teleopctl.node.node_endpoints import NodeEndpoints
from teleopctl.node.parameters.store import (
    PARAM_REL_TOL,
    OnSetCallback,
    ParameterStore,
    PostSetCallback,
    PreSetCallback,
)
from teleopctl.node.values.exceptions import ParameterAlreadyDeclaredException
from teleopctl.node.values.parameter import (
    Parameter,
    ParameterType,
)
from teleopctl.node.values.qos import QoSProfile, qos_profile_parameter_events

if TYPE_CHECKING:
    from rcl_interfaces.msg import (
        ListParametersResult,
        ParameterDescriptor,
        ParameterValue,
        SetParametersResult,
    )

    Default: TypeAlias = AllowableParameterValue | ParameterType
    from teleopctl.node.endpoints.qos_overrides import QoSOverridingOptions


class NodeParameters(NodeEndpoints):
    """Base of nodes with the methods for parameters."""

    PARAM_REL_TOL = PARAM_REL_TOL

    def _start_parameters(
        self, given: Iterable[Parameter], *, allow_undeclared: bool, start_services: bool
    ) -> None:
        """Read the overrides and open the services."""
        overrides: dict[str, Parameter] = {}
        # As in rclpy: the node's command line overrides the process's, the program overrides both.
        for arguments in reversed(self._arguments):
            values = arguments.parameter_overrides(self._name, self._namespace)
            overrides.update((name, Parameter(name, value=value)) for name, value in values.items())
        overrides.update((parameter.name, parameter) for parameter in given)
        self._parameter_events = self.create_publisher(
            get_message("rcl_interfaces/msg/ParameterEvent"),
            "/parameter_events",
            qos_profile_parameter_events,
        )
        self._parameters = ParameterStore(
            overrides, allow_undeclared=allow_undeclared, on_change=self._publish_change
        )
        if start_services:
            from teleopctl.node.parameters.service import ParameterService

            ParameterService(self, self._parameters)

    def _declare_overrides(self) -> None:
        for name, parameter in self._parameters.overrides.items():
            if not self.has_parameter(name):
                self.declare_parameter(name, parameter.value)

    def _publish_change(
        self, new: list[Parameter], changed: list[Parameter], deleted: list[Parameter]
    ) -> None:
        if not self._parameter_events.node.context.session_is_open:
            return
        from teleopctl.node.parameters.service import parameter_event

        self._parameter_events.publish(
            parameter_event(
                self.get_fully_qualified_name(),
                self._clock.now().to_msg(),
                new,
                changed,
                deleted,
            )
        )

    def _overridden_qos(
        self,
        profile: QoSProfile,
        options: QoSOverridingOptions,
        side: Literal["publisher", "subscription"],
        topic: str,
    ) -> QoSProfile:
        from teleopctl.node.endpoints.qos_overrides import apply_qos_overrides

        def declare(
            name: str, default: AllowableParameterValue, descriptor: ParameterDescriptor
        ) -> Parameter:
            if self.has_parameter(name):
                return self.get_parameter(name)
            return self.declare_parameter(name, default, descriptor)

        return apply_qos_overrides(profile, options, side, topic, declare)

    # -- declaring -------------------------------------------------------------------------------

    def declare_parameter(
        self,
        name: str,
        value: Default = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter:
        """Declare and return a parameter; an override replaces the default value.

        Args:
            name: Name of the parameter, parts separated by dots.
            value: Default value, or a ``Parameter.Type`` for a parameter without a default.
            descriptor: Descriptor of the parameter, such as its range and description.
            ignore_override: Whether to keep the default even if there is an override.

        Raises:
            ParameterAlreadyDeclaredException: The parameter is declared already.
            InvalidParameterException: The name is empty.
            InvalidParameterTypeException: The value or the override has another type.
            InvalidParameterValueException: The value is out of range, or a callback rejects it.
        """
        return self._parameters.declare(name, value, descriptor, ignore_override)

    def declare_parameters(
        self,
        namespace: str,
        parameters: Iterable[
            tuple[str] | tuple[str, Default] | tuple[str, Default, ParameterDescriptor]
        ],
        ignore_override: bool = False,
    ) -> list[Parameter]:
        """Declare and return parameters below a prefix, each ``(name[, value[, descriptor]])``."""
        prefix = f"{namespace}." if namespace else ""
        padded = [(*entry, None, None)[:3] for entry in parameters]
        entries = [(prefix + name, value, descriptor) for name, value, descriptor in padded]
        names = [name for name, _, _ in entries]
        if declared := [name for name in names if self.has_parameter(name)]:
            raise ParameterAlreadyDeclaredException(declared)
        # Of entries with the same name, the last one is declared.
        made = {
            name: self.declare_parameter(name, value, descriptor, ignore_override)
            for name, value, descriptor in {entry[0]: entry for entry in entries}.values()
        }
        return [made[name] for name in names]

    def undeclare_parameter(self, name: str) -> None:
        """Undeclare a parameter by name; raise if it is undeclared already or read-only."""
        self._parameters.undeclare(name)

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return self._parameters.has(name)

    # -- reading ---------------------------------------------------------------------------------

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter; raise if statically typed but unset, or undeclared unless allowed.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared, which is not allowed.
            ParameterUninitializedException: The parameter is statically typed and has no value.
        """
        return self._parameters.readable(name)

    def get_parameters(self, names: Iterable[str]) -> list[Parameter]:
        """Return several parameters by name; raises as `get_parameter`."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter; if undeclared or without value, the alternative (None: unset one)."""
        parameter = self._parameters.find(name)
        if parameter is not None and parameter.value is not None:
            return parameter
        return Parameter(name) if alternative_value is None else alternative_value

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by their names without the prefix."""
        return self._parameters.by_prefix(prefix)

    def get_parameter_overrides(self) -> dict[str, Parameter]:
        """Return the overrides of the command line, files and constructor, by name (ours)."""
        return dict(self._parameters.overrides)

    def get_parameter_type(self, name: str) -> ParameterType:
        """Return the type of a parameter; raises as `get_parameter`."""
        return self.get_parameter_types([name])[0]

    def get_parameter_types(self, names: Iterable[str]) -> list[ParameterType]:
        """Return the types of several parameters; raises as `get_parameter`."""
        return [self.get_parameter(name).type_ for name in names]

    def list_parameters(self, prefixes: Sequence[str], depth: int) -> ListParametersResult:
        """Return the parameter names below prefixes, as a ``ListParametersResult``.

        Args:
            prefixes: Prefixes of the names; empty for all parameters.
            depth: Largest number of name parts below a prefix; 0 is unlimited.

        Raises:
            TypeError: ``prefixes`` is not a sequence of names, or ``depth`` not an integer.
            ValueError: ``depth`` is negative.
        """
        if isinstance(prefixes, str) or not isinstance(prefixes, Sequence):
            raise TypeError("The prefixes argument must be a list")
        if not isinstance(depth, int):
            raise TypeError("The depth must be an integer")
        if depth < 0:
            raise ValueError("The depth must not be negative")
        names, parents = self._parameters.list_names(prefixes, depth)
        message: type[ListParametersResult] = get_message("rcl_interfaces/msg/ListParametersResult")
        return message(names=names, prefixes=parents)

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a parameter's descriptor; if undeclared raise, or return an empty one if allowed.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared, which is not allowed.
        """
        return self._parameters.descriptor(name)

    def describe_parameters(self, names: Iterable[str]) -> list[ParameterDescriptor]:
        """Return the descriptors of several parameters; raises as `describe_parameter`."""
        return [self.describe_parameter(name) for name in names]

    def set_descriptor(
        self,
        name: str,
        descriptor: ParameterDescriptor,
        alternative_value: ParameterValue | None = None,
    ) -> ParameterValue:
        """Replace a parameter's descriptor, maybe also its value; return the resulting value.

        Args:
            name: Name of a declared parameter.
            descriptor: The new ``rcl_interfaces/msg/ParameterDescriptor``.
            alternative_value: ``ParameterValue`` to set if the present value does not fit.

        Returns:
            The resulting value, as ``rcl_interfaces/msg/ParameterValue``.

        Raises:
            ParameterNotDeclaredException: The parameter is undeclared.
            ParameterImmutableException: The parameter is read-only.
            InvalidParameterValueException: Neither value fits the descriptor.
        """
        alternative = (
            None
            if alternative_value is None
            else Parameter(name, value=parameter_value_to_python(alternative_value))
        )
        return self._parameters.describe(name, descriptor, alternative).get_parameter_value()

    # -- setting ---------------------------------------------------------------------------------

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[SetParametersResult]:
        """Set parameters one by one; return a ``SetParametersResult`` for each.

        Raises:
            ParameterNotDeclaredException: A parameter is undeclared, which is not allowed; the
                parameters before it have been set.
            TypeError: An item is not a `Parameter`.
        """
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: Sequence[Parameter]) -> SetParametersResult:
        """Set all parameters or none; return one ``SetParametersResult``.

        Raises:
            ParameterNotDeclaredException: A parameter is undeclared, which is not allowed.
            TypeError: An item is not a `Parameter`.
        """
        for parameter in parameter_list:
            if not isinstance(parameter, Parameter):
                raise TypeError(f"{parameter!r} is no Parameter")
        return self._parameters.set_atomically(
            parameter_list, check=self._parameters.check_declared
        )

    def add_pre_set_parameters_callback(self, callback: PreSetCallback) -> None:
        """Register a callback that may change the parameters to set; the oldest is called first."""
        self._parameters.pre_set_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: OnSetCallback) -> None:
        """Register a callback that accepts or rejects new values; the newest is called first."""
        self._parameters.on_set_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Register a callback to call after parameters were set; the newest is called first."""
        self._parameters.post_set_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: PreSetCallback) -> None:
        """Unregister a callback of `add_pre_set_parameters_callback`; raise if it was not added.

        Raises:
            ValueError: The callback was not added.
        """
        self._parameters.pre_set_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: OnSetCallback) -> None:
        """Unregister a callback of `add_on_set_parameters_callback`; raise if it was not added.

        Raises:
            ValueError: The callback was not added.
        """
        self._parameters.on_set_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Unregister a callback of `add_post_set_parameters_callback`; raise if it was not added.

        Raises:
            ValueError: The callback was not added.
        """
        self._parameters.post_set_callbacks.remove(callback)
