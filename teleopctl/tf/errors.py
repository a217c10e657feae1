"""What can go wrong with a transform, under tf2's names."""

from teleopctl.errors import TeleopctlError


class TransformException(TeleopctlError):
    """A transform is not available."""


class LookupException(TransformException):
    """A frame is not known."""


class ConnectivityException(TransformException):
    """No chain of transforms joins the two frames."""


class ExtrapolationException(TransformException):
    """The requested time lies outside the buffered transforms."""


class InvalidArgumentException(TransformException):
    """A frame's name is not allowed."""


class TimeoutException(TransformException):
    """A transform did not arrive in time."""
