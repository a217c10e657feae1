"""Arguments and options that many verbs share."""

from typing import Annotated

from teleopctl.cli.verb import Argument, Option

TopicName = Annotated[str, Argument(help="The topic.", complete="topics")]
ServiceName = Annotated[str, Argument(help="The service.", complete="services")]
NodeName = Annotated[str, Argument(help="The node.", complete="nodes")]

AsJson = Annotated[bool, Option("--json", help="Print one JSON document.")]
