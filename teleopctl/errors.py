"""Errors with a message for the user, as a tree of classes that programs can catch.

```
TeleopctlError                       exit status 1
├── UsageError                       2: wrong option, argument, type or variable
│   ├── AmbiguousNameError           the name matches several things
│   ├── InvalidTypeNameError         malformed name of a message, service or action
│   └── UnsupportedError             a feature of ROS 2 that teleopctl lacks so far
├── NotFoundError                    nothing has that name (package, file, node, type, frame …)
│   └── UnknownPluginError           no plug-in has that name
├── UnavailableError                 a resource exists, but does not respond or cannot be used
│   ├── BrokenPluginError            a plug-in cannot be imported, or is of another kind
│   ├── MissingExtraError            a library that `pip install teleopctl` leaves out
│   ├── RouterNotRunning             … wire/session.py
│   ├── ServiceUnavailableError      … node/values/exceptions.py
│   └── ControllerManagerUnavailableError  … control/client.py
├── RefusedError                     a node or program refused the request
├── InvalidParameterError            invalid value of a parameter
├── HardwareError                    a hardware component cannot be loaded or started
├── InvalidDescriptionError          a robot description: xacro, URDF, <ros2_control>, <gazebo>
│   └── UnknownFormatError           unknown format of a description
├── InvalidMessageError              bytes, YAML or a value that do not fit the message type
│   └── InvalidDefinitionError       invalid .msg, .srv or .action definition
├── InvalidFileError                 another invalid file: parameters, configuration, text
├── LaunchError                      a launch file, or a process of a launch
├── SystemFailureError               an error of the operating system: disk, folder, process
├── DefectError                      an unexpected exception: a defect of teleopctl
├── PlanningError                    … kinematics/error_codes.py: no motion, with MoveIt's code
├── ExecutionError                   … commander/running_arm.py: a motion that ended too early
├── TransformException               … tf/errors.py, under tf2's names
├── NameValidationException          … node/values/exceptions.py, under rclpy's names
└── ParameterException               … node/values/exceptions.py, under rclpy's names
```

The message describes the problem and its place, the hint a remedy. The class determines the exit
status.
"""

from __future__ import annotations

# Known to type checkers by its name; the import of typing costs short commands 6 ms.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import ClassVar, Self

EXIT_INTERRUPTED = 130
"""The exit status after Ctrl-C, as in shells."""

# Longest list of names that fits on a line.
_MOST_NAMES = 8

# Least similarity of a name that is suggested.
_SIMILAR = 0.65


class TeleopctlError(Exception):
    """Base class of teleopctl's errors, with a message for the user and perhaps a hint.

    The command line prints ``message`` and ``hint`` to stderr and ends with ``exit_status``;
    a traceback appears only with ``--debug``. The other classes are in `teleopctl.errors`.

    Args:
        message: Problem and its place, in one sentence.
        hint: Suggested remedy, or None.

    Attributes:
        place: Place of the cause, such as ``file:line``, as set by `at`; part of the message.

    Example:
        >>> import teleopctl
        >>> try:
        ...     teleopctl.load_robot("none.urdf")
        ... except teleopctl.TeleopctlError as error:
        ...     print(type(error).__name__, error.message)
        NotFoundError none.urdf: no such file
    """

    exit_status: ClassVar[int] = 1

    def __init__(self, message: str, *, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.place: str | None = None

    def at(self, place: str) -> Self:
        """Return a copy of the error whose message begins with a place, such as ``file:line``."""
        import copy  # takes longer to load than many commands take to decide

        located = copy.copy(self)
        located.place = place
        located.message = f"{place}: {self.message}"
        located.args = (located.message,)
        return located


class UsageError(TeleopctlError):
    """An option, argument, type or environment variable is invalid."""

    exit_status = 2


class AmbiguousNameError(UsageError):
    """A name matches several things, where one is required."""


class InvalidTypeNameError(UsageError):
    """A text does not name a type of the required kind: message, service or action."""


class UnsupportedError(UsageError):
    """A requested feature, format or setting of ROS 2 is not supported by teleopctl."""


class NotFoundError(TeleopctlError):
    """Nothing has this name: package, program, file, node, topic, type, frame or controller."""


class UnknownPluginError(NotFoundError):
    """No plug-in has this name."""


class UnavailableError(TeleopctlError):
    """A resource exists but does not answer, or cannot be used now."""


class BrokenPluginError(UnavailableError):
    """A plug-in cannot be imported, or lacks the base class that its kind requires."""


class MissingExtraError(UnavailableError):
    """An optional library is not installed."""


class RefusedError(TeleopctlError):
    """A node or program refused a request."""


class InvalidParameterError(TeleopctlError):
    """A parameter has an invalid value."""


class HardwareError(TeleopctlError):
    """A hardware component cannot be loaded, initialized or activated."""


class InvalidDescriptionError(TeleopctlError):
    """A robot or world description is invalid."""


class UnknownFormatError(InvalidDescriptionError):
    """A description's format is unknown."""


class InvalidMessageError(TeleopctlError):
    """Bytes, YAML or a value are no valid message."""


class InvalidDefinitionError(InvalidMessageError):
    """A ``.msg``, ``.srv`` or ``.action`` cannot be read."""


class InvalidFileError(TeleopctlError):
    """A file is invalid: parameters, configuration or text."""


class LaunchError(TeleopctlError):
    """A launch file cannot be evaluated, or its processes failed."""


class SystemFailureError(TeleopctlError):
    """The operating system refused an operation."""


class DefectError(TeleopctlError):
    """An unexpected exception: a defect of teleopctl."""


def did_you_mean(name: str, known: Iterable[str], most: int = 3) -> str | None:
    """Return a hint with up to three (or ``most``) similarly spelt names; None for none."""
    matches = similar_names(name, known, most)
    return f"Did you mean {' or '.join(matches)}?" if matches else None


def similarity(one: str, other: str) -> float:
    """Return twice the length of the longest common subsequence over both lengths, from 0 to 1.

    0 means that no letter is common, 1 that the texts are equal.
    """
    # A bit per letter of `one`: Hyyrö's algorithm, which computes a row of lengths at once.
    places: dict[str, int] = {}
    for at, letter in enumerate(one):
        places[letter] = places.get(letter, 0) | 1 << at
    all_bits = row = (1 << len(one)) - 1
    for letter in other:
        common = row & places.get(letter, 0)
        row = (row + common | row - common) & all_bits
    return 2 * (len(one) - row.bit_count()) / (len(one) + len(other) or 1)


def similar_names(
    name: str, known: Iterable[str], most: int = 3, least: float = _SIMILAR
) -> list[str]:
    """Return the names that are spelled like one, the most similar first.

    Args:
        name: Name to compare with.
        known: Names to choose from.
        most: Largest number of names to return.
        least: Least `similarity` of a returned name.
    """
    ranked = sorted((-similarity(name, each), each) for each in known)
    return [each for rank, each in ranked[:most] if -rank >= least]


def existing_names_hint(
    kind: str, missing: Iterable[str], known: Iterable[str], others: Iterable[str] = ()
) -> str:
    """Return a hint about unknown names: a list of existing ones, then similar ones, if any.

    Args:
        kind: Kind of the named things, in the plural: ``frames``.
        missing: Requested names that do not exist.
        known: Existing names, which are listed.
        others: Further names, which are only suggested if they are similar.
    """
    names = sorted(known)
    more = len(names) - _MOST_NAMES
    hints = [hint for name in missing if (hint := did_you_mean(name, {*names, *others}))]
    if len(names) == 1 and hints == [f"Did you mean {names[0]}?"]:
        return hints[0]
    verb = "is" if len(names) == 1 else "are"
    text = f"There {verb} {', '.join(names[:_MOST_NAMES])}" if names else f"There are no {kind}"
    text += f" and {more} more." if more > 0 else "."
    return " ".join([text, *hints])
