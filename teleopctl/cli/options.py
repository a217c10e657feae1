"""Arguments and options that many verbs share."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option

TopicName = Annotated[str, Argument(help="The topic.", complete="topics")]
ServiceName = Annotated[str, Argument(help="The service.", complete="services")]
NodeName = Annotated[str, Argument(help="The node.", complete="nodes")]

CountTopics = Annotated[bool, Option("-c", "--count-topics", help="Print only how many there are.")]
CountServices = Annotated[
    bool, Option("-c", "--count-services", help="Print only how many there are.")
]
HiddenTopics = Annotated[
    bool,
    Option("--include-hidden-topics", help="List names with a part that starts with _, too."),
]
HiddenServices = Annotated[
    bool,
    Option("--include-hidden-services", help="List names with a part that starts with _, too."),
]
AsJson = Annotated[bool, Option("--json", help="Print one JSON document.")]
UseSimTime = Annotated[
    bool, Option("-s", "--use-sim-time", help="Follow /clock instead of this machine's clock.")
]
UpTimeout = Annotated[
    float | None,
    Option(
        "--timeout",
        help="With --detach: how long to wait until everything is up; 300.",
        metavar="SECONDS",
    ),
]
StallTimeout = Annotated[
    float | None,
    Option(
        "--stall-timeout",
        help="With --detach: how long to wait while nothing gets on; 30.",
        metavar="SECONDS",
    ),
]
