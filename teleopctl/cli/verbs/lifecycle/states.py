"""``teleopctl lifecycle get``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument
from teleopctl.cli.verbs.lifecycle.graph_lifecycles import (
    HiddenNodes,
    Timeout,
    open_lifecycles,
)
from teleopctl.errors import TeleopctlError


def get_state(
    node_name: Annotated[
        str | None, Argument(help="The node; otherwise all nodes.", complete="managed_nodes")
    ] = None,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Print the state of one node, or of all managed nodes."""
    with open_lifecycles(timeout) as lifecycles:
        if node_name:
            names = [lifecycles.find(node_name, include_hidden=include_hidden)]
        else:
            names = lifecycles.nodes(include_hidden=include_hidden)
        answers = lifecycles.ask_all(names, "GetState", "get_state")
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if node_name and failures:
        raise failures[0]
    states = {
        name: answer.current_state
        for name, answer in answers.items()
        if not isinstance(answer, TeleopctlError)
    }
    if as_json:
        console.out_json([{"node": n, "state": s.label, "id": s.id} for n, s in states.items()])
    else:
        console.out_lines(
            f"{'' if node_name else f'{name}: '}{state.label} [{state.id}]"
            for name, state in states.items()
        )
    console.flush()
    for failure in failures:
        console.warn(failure.message)
