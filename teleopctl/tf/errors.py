"""Errors of transform lookups, under tf2's names."""

from teleopctl.errors import TeleopctlError


class TransformException(TeleopctlError):
    """A transform is not available."""


class LookupException(TransformException):
    """A frame is unknown."""


class ConnectivityException(TransformException):
    """The two frames are not connected."""


class ExtrapolationException(TransformException):
    """The requested time lies outside the buffered transforms."""


class InvalidArgumentException(TransformException):
    """A frame name is invalid."""


class TimeoutException(TransformException):
    """A transform did not arrive in time."""
