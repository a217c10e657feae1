"""Errors of transform lookups, under tf2's names."""

from teleopctl.errors import TeleopctlError


class TransformException(TeleopctlError):
    """Error: a transform is not available; base of tf2's exceptions."""


class LookupException(TransformException):
    """Error: a frame is unknown."""


class ConnectivityException(TransformException):
    """Error: two frames are not connected in the tree."""


class ExtrapolationException(TransformException):
    """Error: the requested time lies outside the buffered transforms."""


class InvalidArgumentException(TransformException):
    """Error: a frame name is invalid."""


class TimeoutException(TransformException):
    """Error: a transform did not arrive in time."""
