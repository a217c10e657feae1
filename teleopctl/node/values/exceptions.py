"""Exceptions of the client library, by rclpy's names (``rclpy.exceptions``)."""

from __future__ import annotations

from teleopctl.base.printable import shortened
from teleopctl.base.typed import TYPE_CHECKING, ClassVar
from teleopctl.errors import TeleopctlError, UnavailableError

if TYPE_CHECKING:
    from teleopctl.node.values.parameter import Parameter


class NotInitializedException(TeleopctlError):
    """A context was used before ``init()`` or after ``shutdown()``.

    Args:
        message: Further description, or None.
    """

    def __init__(self, message: str | None = None) -> None:
        further = f". msg:{message}" if message else ""
        super().__init__(
            f"rclpy.init() has not been called{further}", hint="call rclpy.init() first"
        )


class ExternalShutdownException(Exception):
    """The context was shut down during a wait, or by a signal during spinning."""


class ShutdownBySignalException(NotInitializedException, ExternalShutdownException):
    """A context was used after a signal ended it; ends a program quietly."""

    def __init__(self) -> None:
        TeleopctlError.__init__(self, "the context was shut down by a signal")


class ShutdownException(Exception):
    """An executor was used after it was shut down."""


class ROSInterruptException(ExternalShutdownException):
    """A rate's sleep was interrupted by a shutdown or by the rate's destruction."""

    def __init__(self) -> None:
        super().__init__("rclpy.shutdown() has been called")


class TimeoutException(Exception):
    """No callback became ready before the timeout."""


class ConditionReachedException(Exception):
    """The condition given to `wait_for_ready_callbacks` was true at the call."""


class InvalidHandle(Exception):
    """An entity was used after it was destroyed."""


class RCLError(RuntimeError):
    """Base of errors that correspond to those of rclpy's C library."""


class ContextInvalidError(RCLError):
    """A message was published after the context's shutdown."""

    def __init__(self) -> None:
        super().__init__("Failed to publish: publisher's context is invalid")


class ContextEndedError(ContextInvalidError, ExternalShutdownException):
    """A message was published after a signal ended the context; ends a program quietly."""


class TimerCancelledError(RCLError):
    """A canceled timer was called by its handle."""


class NodeNameNonExistentError(RCLError):
    """The node of a graph query is not in the graph."""


class ServiceUnavailableError(UnavailableError):
    """A request gets no response: no server is there, or it has left the graph."""


class NameValidationException(TeleopctlError):
    """A node name, namespace, topic name or service name violates ROS 2's rules.

    Args:
        name: The invalid name.
        error_msg: Rule that the name violates.
        invalid_index: Position of the first offending character.
    """

    kind: ClassVar[str] = "name"

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        mark = " " * invalid_index
        super().__init__(f"Invalid {self.kind}: {error_msg}:\n  '{name}'\n   {mark}^")
        self.name_type = self.kind
        self.name = name
        self.error_msg = error_msg
        self.invalid_index = invalid_index


class InvalidNodeNameException(NameValidationException):
    """A node name is invalid."""

    kind = "node name"


class InvalidNamespaceException(NameValidationException):
    """A namespace is invalid."""

    kind = "namespace"


class InvalidTopicNameException(NameValidationException):
    """A topic name is invalid."""

    kind = "topic name"


class InvalidServiceNameException(NameValidationException):
    """A service name is invalid."""

    kind = "service name"


class UnknownSubstitutionError(TeleopctlError, ValueError):
    """A topic or service name contains an unknown substitution in braces.

    Args:
        name: The invalid name.
        substitution: The unknown substitution, with its braces.
    """

    def __init__(self, name: str, substitution: str) -> None:
        super().__init__(f"topic name '{name}' is invalid: unknown substitution: {substitution}")


class ParameterException(TeleopctlError):
    """Base of exceptions about parameters.

    Args:
        error_msg: Description of the problem, without the names.
        parameters: Name or names of the parameters.
    """

    def __init__(self, error_msg: str, parameters: str | list[str] | tuple[str, ...]) -> None:
        super().__init__(f"{error_msg}: {parameters}")
        self.parameters = parameters


class ParameterNotDeclaredException(ParameterException):
    """An undeclared parameter was used."""

    def __init__(self, parameters: str | list[str]) -> None:
        super().__init__("Invalid access to undeclared parameter(s)", parameters)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter was declared twice."""

    def __init__(self, parameters: str | list[str]) -> None:
        super().__init__("Parameter(s) already declared", parameters)


class ParameterUninitializedException(ParameterException):
    """A parameter was read that was declared by type only and has no value."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__(f"The parameter '{parameter_name}' is not initialized", parameter_name)


class ParameterImmutableException(ParameterException):
    """A read-only parameter was undeclared, or its descriptor replaced."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__("Attempted to modify read-only parameter", parameter_name)


class InvalidParameterException(ParameterException):
    """A parameter name is invalid: it is empty."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__("Invalid parameter name", parameter_name)


class InvalidParameterTypeException(ParameterException):
    """A value has another type than its parameter was declared with."""

    def __init__(self, desired_parameter: Parameter, expected_type: str) -> None:
        value = shortened(str(desired_parameter.value))
        super().__init__(
            f"Trying to set parameter '{desired_parameter.name}' to '{value}' of type "
            f"'{desired_parameter.type_.name}', expecting type '{expected_type}'",
            desired_parameter.name,
        )


class InvalidParameterValueException(ParameterException):
    """A parameter value is out of range, or a callback rejected it."""

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        super().__init__(
            f"Invalid parameter value ({shortened(str(value))}) for parameter. Reason: {reason}",
            parameter,
        )
