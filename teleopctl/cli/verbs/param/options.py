"""What the verbs of ``teleopctl param`` have in common on the command line."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option

Nodes = Annotated[str, Argument(help="The node, or a pattern such as '/arm/*'.", complete="nodes")]
ParameterName = Annotated[str, Argument(help="The parameter.", complete="parameter_names")]
HiddenNodes = Annotated[
    bool,
    Option("--include-hidden-nodes", help="Let patterns mean nodes whose name starts with _, too."),
]
Timeout = Annotated[
    float,
    Option("--timeout", help="How long to wait until the node is there.", metavar="SECONDS"),
]
ServiceTimeout = Annotated[
    float,
    Option("--service-timeout", help="How long to wait for answers.", metavar="SECONDS"),
]
