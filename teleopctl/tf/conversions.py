"""Transformations and conversions of registered types, with the names of ``tf2_ros``."""

from __future__ import annotations

import abc
import copy
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from teleopctl.interfaces import Stamp
from teleopctl.tf.messages import TimeLike

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

# Any, here and below: objects of any registered type.

# Called with an object and the TransformStamped to apply; returns a new object.
DoTransform = Callable[[Any, Any], Any]
Convert = Callable[[Any], Any]

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")

_transforms: dict[type, DoTransform] = {}
_to_message: dict[type, Convert] = {}
_from_message: dict[type, Convert] = {}
_direct: dict[tuple[type, type], Convert] = {}


class TypeException(Exception):
    """Error: no transformation or conversion is registered for a type."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(Exception):
    """Error of tf2_ros for buffer classes that lack a method; teleopctl itself never raises it."""

    def __init__(self) -> None:
        self.errstr = "the buffer has no method of this name"
        super().__init__(self.errstr)


class TransformRegistration:
    """Table of functions that transform stamped types, shared by all instances of this class."""

    def add(self, key: type, callback: DoTransform) -> None:
        """Register the function that transforms objects of a type by a ``TransformStamped``."""
        _transforms[key] = callback

    def get(self, key: type) -> DoTransform:
        """Return the function registered to transform a type; TypeException if there is none.

        Raises:
            TypeException: No function is registered for the type.
        """
        return _known(_transforms, key)


class ConvertRegistration:
    """Table of functions that convert types to and from messages, shared by all instances."""

    def add_from_msg(self, key: type, callback: Convert) -> None:
        """Register the function that converts a message to the type ``key``."""
        _from_message[key] = callback

    def add_to_msg(self, key: type, callback: Convert) -> None:
        """Register the function that converts objects of the type ``key`` to a message."""
        _to_message[key] = callback

    def add_convert(self, key: tuple[type, type], callback: Convert) -> None:
        """Register the direct conversion function of a type pair (from, to)."""
        _direct[key] = callback

    def get_from_msg(self, key: type) -> Convert:
        """Return the function that converts a message to the type; TypeException without one."""
        return _known(_from_message, key)

    def get_to_msg(self, key: type) -> Convert:
        """Return the function that converts the type to a message; TypeException without one."""
        return _known(_to_message, key)

    def get_convert(self, key: tuple[type, type]) -> Convert:
        """Return the function registered for a type pair (from, to); TypeException without one."""
        return _known(_direct, key)


def _known(table: Mapping[_Key, _Value], key: _Key) -> _Value:
    if key not in table:
        raise TypeException(f"{key} is not registered with tf2_ros")
    return table[key]


def convert(value: Any, type_: type) -> Any:
    """Return a value converted to a type, directly or via a message; a copy if it has the type.

    Raises:
        TypeException: No conversion between the two types is registered.
    """
    if (type(value), type_) in _direct:
        return _direct[type(value), type_](value)
    if type(value) is type_:
        return copy.deepcopy(value)
    registered = ConvertRegistration()
    return registered.get_from_msg(type_)(registered.get_to_msg(type(value))(value))


def Stamped(obj: Any, stamp: Stamp, frame_id: str) -> Any:  # noqa: N802 -- tf2_ros's name
    """Set the header of an object, and return the object."""
    from teleopctl.interfaces import get_message

    obj.header = get_message("std_msgs/msg/Header")(stamp=stamp, frame_id=frame_id)
    return obj


class BufferInterface(abc.ABC):
    """Abstract base of transform buffers; transforms stamped objects of registered types."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    @abc.abstractmethod
    def lookup_transform(
        self, target_frame: str, source_frame: str, time: TimeLike, timeout: TimeLike | None = None
    ) -> TransformStamped:
        """Return the ``TransformStamped`` from source to target frame; subclasses define this."""

    @abc.abstractmethod
    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: TimeLike,
        source_frame: str,
        source_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
    ) -> TransformStamped:
        """Return the transform between frames at two times; subclasses define this."""

    def transform(
        self,
        object_stamped: Any,
        target_frame: str,
        timeout: TimeLike | None = None,
        new_type: type | None = None,
    ) -> Any:
        """Return a stamped object transformed to another frame, as ``new_type`` if one is given.

        Args:
            object_stamped: Object with a header and of a registered type. The import of
                ``tf2_geometry_msgs`` registers the types of ``geometry_msgs``.
            target_frame: Frame to transform the object to.
            timeout: Longest ``Duration`` to wait for the transform; None does not wait.
            new_type: Type of the result; None for the type of the object.

        Raises:
            TransformException: As ``lookup_transform`` does.
            TypeException: The type of the object is not registered.
        """
        header = object_stamped.header
        found = self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        return self._apply(object_stamped, found, new_type)

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: TimeLike,
        fixed_frame: str,
        timeout: TimeLike | None = None,
        new_type: type | None = None,
    ) -> Any:
        """Return a stamped object transformed to another frame at another time, via a fixed frame.

        Args:
            object_stamped: As for `transform`.
            target_frame: Frame to transform the object to.
            target_time: Time of the target frame.
            fixed_frame: Frame that does not move between the two times.
            timeout: As for `transform`.
            new_type: As for `transform`.

        Raises:
            TransformException: As ``lookup_transform_full`` does.
            TypeException: The type of the object is not registered.
        """
        header = object_stamped.header
        found = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        return self._apply(object_stamped, found, new_type)

    def _apply(
        self, object_stamped: Any, transform: TransformStamped, new_type: type | None
    ) -> Any:
        moved = self.registration.get(type(object_stamped))(object_stamped, transform)
        return moved if new_type is None else convert(moved, new_type)
