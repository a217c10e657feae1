"""Arguments and options that many verbs share, and checks of their values."""

import os

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import UsageError

TopicName = Annotated[str, Argument(help="The topic.", complete="topics")]
ServiceName = Annotated[str, Argument(help="The service.", complete="services")]
NodeName = Annotated[str, Argument(help="The node.", complete="nodes")]

CountTopics = Annotated[bool, Option("-c", "--count-topics", help="Print only the number.")]
CountServices = Annotated[bool, Option("-c", "--count-services", help="Print only the number.")]
HiddenTopics = Annotated[
    bool,
    Option("--include-hidden-topics", help="Include names with a part that starts with _."),
]
HiddenServices = Annotated[
    bool,
    Option("--include-hidden-services", help="Include names with a part that starts with _."),
]
AsJson = Annotated[bool, Option("--json", help="Print one JSON document.")]
UseSimTime = Annotated[
    bool, Option("-s", "--use-sim-time", help="Follow /clock instead of this machine's clock.")
]
PictureFile = Annotated[
    str | None,
    Option(
        "-o",
        "--output",
        help="Write a picture instead: PNG, SVG or PDF, by the file name.",
        metavar="FILE",
    ),
]
LoggerServices = Annotated[
    bool,
    Option(
        "--logger-services",
        help="Let `teleopctl logger` change levels, as TELEOPCTL_LOGGER_SERVICES=1 does.",
    ),
]
UpTimeout = Annotated[
    float | None,
    Option(
        "--timeout",
        help="With --detach: longest time until everything is up; 300.",
        metavar="SECONDS",
    ),
]
StallTimeout = Annotated[
    float | None,
    Option(
        "--stall-timeout",
        help="With --detach: longest time without progress; 30.",
        metavar="SECONDS",
    ),
]


def turn_on_logger_services() -> None:
    """Turn on the logger services of the nodes of this process and of those that it starts."""
    os.environ["TELEOPCTL_LOGGER_SERVICES"] = "1"


def check_not_negative(**options: float | None) -> None:
    """Raise a UsageError if an option, passed as ``name=value``, is negative; None is allowed.

    Raises:
        UsageError: A value is negative.
    """
    for name, value in options.items():
        if value is not None and value < 0:
            raise UsageError(f"{_flag(name)} must not be negative, got {value:g}")


def check_positive(**options: float | None) -> None:
    """Raise a UsageError if an option, passed as ``name=value``, is not positive; None passes.

    Raises:
        UsageError: A value is zero or negative.
    """
    for name, value in options.items():
        if value is not None and value <= 0:
            raise UsageError(f"{_flag(name)} must be greater than zero, got {value:g}")


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"
