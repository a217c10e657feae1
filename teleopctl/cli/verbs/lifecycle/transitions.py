"""``teleopctl lifecycle list`` and ``set``."""

from collections.abc import Sequence

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.lifecycle.graph_lifecycles import (
    HiddenNodes,
    Lifecycles,
    ManagedNodeName,
    Timeout,
    open_lifecycles,
)
from teleopctl.errors import NotFoundError, RefusedError


def list_transitions(
    node_name: ManagedNodeName,
    include_hidden: HiddenNodes = False,
    include_all: Annotated[
        bool, Option("-a", "--all", help="List all transitions, not only those possible now.")
    ] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """List the transitions that are possible now."""
    with open_lifecycles(timeout) as lifecycles:
        node = lifecycles.find(node_name, include_hidden=include_hidden)
        transitions = _transitions(
            lifecycles, node, "get_transition_graph" if include_all else "get_available_transitions"
        )
    if as_json:
        console.out_json([_document(transition) for transition in transitions])
        return
    for transition in transitions:
        console.out(f"- {transition.transition.label} [{transition.transition.id}]")
        console.out(f"\tStart: {transition.start_state.label}")
        console.out(f"\tGoal: {transition.goal_state.label}")


def set_state(
    node_name: ManagedNodeName,
    transition: Annotated[
        str, Argument(help="The transition, by label or number.", complete="transitions")
    ],
    include_hidden: HiddenNodes = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Take a node through a transition."""
    with open_lifecycles(timeout) as lifecycles:
        node = lifecycles.find(node_name, include_hidden=include_hidden)
        available = [
            each.transition for each in _transitions(lifecycles, node, "get_available_transitions")
        ]
        wanted = _chosen(available, transition)
        success = lifecycles.change(node, wanted, timeout)
        state = lifecycles.ask(node, "GetState", "get_state").current_state if as_json else None
    if not success:
        raise RefusedError(
            "Transitioning failed", hint=f"`teleopctl lifecycle get {node}` prints where it is now."
        )
    if state is not None:
        console.out_json(
            {"node": node, "transition": wanted.label, "state": state.label, "id": state.id}
        )
    else:
        console.out("Transitioning successful")


# Any, here and below: messages of lifecycle_msgs.
def _transitions(lifecycles: Lifecycles, node: str, service: str) -> Sequence[Any]:
    answer = lifecycles.ask(node, "GetAvailableTransitions", service)
    transitions: Sequence[Any] = answer.available_transitions
    return transitions


def _chosen(available: Sequence[Any], wanted: str) -> Any:
    """The transition of a label, else of a number.

    Raises:
        NotFoundError: None of those that are available is meant.
    """
    for transition in available:
        if transition.label == wanted:
            return transition
    for transition in available:
        if str(transition.id) == wanted:
            return transition
    lines = [f"- {each.label} [{each.id}]" for each in available]
    raise NotFoundError("\n".join(["Unknown transition requested, available ones are:", *lines]))


def _document(transition: Any) -> dict[str, Any]:
    return {
        "transition": transition.transition.label,
        "id": transition.transition.id,
        "start": transition.start_state.label,
        "goal": transition.goal_state.label,
    }
