"""Errors of transform lookups, under tf2's names."""

from teleopctl.errors import TeleopctlError


class TransformException(TeleopctlError):
    """Error of a transform lookup, and base of tf2's other exceptions."""


class LookupException(TransformException):
    """Error: a frame is unknown, or the tree contains a loop."""


class ConnectivityException(TransformException):
    """Error: two frames are not connected in the tree."""


class ExtrapolationException(TransformException):
    """Error: the requested time lies outside the buffered transforms."""


class InvalidArgumentException(TransformException):
    """Error: a frame name is invalid."""


class TimeoutException(TransformException):
    """Error: a buffer server is missing, rejects a lookup, or does not respond in time."""
