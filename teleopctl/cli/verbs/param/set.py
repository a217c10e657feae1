"""``teleopctl param set`` and ``delete``."""

from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import (
    LONGEST_WAIT_S,
    PATIENCE_S,
    Parameters,
    with_each,
)
from teleopctl.cli.verbs.param.options import (
    HiddenNodes,
    Nodes,
    ParameterName,
    ServiceTimeout,
    Timeout,
)
from teleopctl.cli.verbs.param.results import Results
from teleopctl.cli.words.patterns import is_pattern
from teleopctl.errors import RefusedError, UsageError

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage, SetParametersResult


def set_parameter(
    node_name: Nodes,
    parameter_name: ParameterName,
    value: Annotated[str, Argument(help="The new value, as YAML.", complete="parameter_values")],
    more: Annotated[
        list[str] | None,
        Argument(help="More parameters, each with its value.", metavar="NAME VALUE..."),
    ] = None,
    atomic: Annotated[bool, Option("--atomic", help="Set all of them, or none.")] = False,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Change parameters.

    The value is YAML: 1 is an integer, 1.0 a double, true a boolean, "1" a string, [1, 2] an
    array.
    """
    words = [parameter_name, value, *(more or ())]
    if len(words) % 2:
        raise UsageError(
            "Parameters must be provided as name/value pairs: name value [name value ...]. "
            f"Got {len(words)} argument(s).",
            hint=f"'{words[-1]}' has no value.",
        )
    wishes = dict(zip(words[::2], words[1::2], strict=True))
    told = Results(as_json=as_json)
    with Parameters(timeout, service_timeout) as parameters:
        nodes = parameters.meant(node_name, include_hidden=include_hidden)
        setting = _Setting(parameters, nodes, wishes, told, is_pattern=is_pattern(node_name))
        status = setting.together() if atomic else setting.each()
    told.finish()
    return status


class _Setting:
    """Parameters of one or more nodes, to be set to the same values."""

    def __init__(
        self,
        parameters: Parameters,
        nodes: Sequence[str],
        wishes: dict[str, str],
        told: Results,
        *,
        is_pattern: bool,
    ) -> None:
        self._parameters = parameters
        self._nodes = nodes
        self._wishes = wishes
        self._told = told
        self._names_nodes = is_pattern
        self._are_several = len(wishes) > 1

    def together(self) -> int:
        """Set all parameters of a node, or none."""
        wanted = [_message(name, text) for name, text in self._wishes.items()]

        def set_together(node: str) -> bool:
            answer = self._parameters.ask(node, "SetParametersAtomically", parameters=wanted)
            texts = [self._as_text(each) for each in wanted]
            if not answer.result.successful and texts != wanted:
                again = self._parameters.ask(node, "SetParametersAtomically", parameters=texts)
                answer = again if again.result.successful else answer
            how = "parameters{} atomically"
            return self._tell(node, how, list(self._wishes), answer.result)

        return int(not with_each(self._nodes, set_together, is_one=not self._names_nodes))

    def each(self) -> int:
        """Set the parameters one by one."""

        def set_each(node: str) -> bool:
            all_well = True
            for name, result in self._set(node).items():
                before = f"{name}: " if self._are_several else ""
                all_well &= self._tell(node, "parameter{}", [name], result, before)
            return all_well

        return int(not with_each(self._nodes, set_each, is_one=not self._names_nodes))

    def _set(self, node: str) -> "dict[str, SetParametersResult]":
        wanted = [_message(name, text) for name, text in self._wishes.items()]
        results = dict(self._parameters.set(node, wanted))
        refused = [each for each in wanted if not results[each.name].successful]
        texts = [text for each in refused if (text := self._as_text(each)) != each]
        if texts:
            again = self._parameters.set(node, texts)
            results |= {name: result for name, result in again.items() if result.successful}
        return results

    def _as_text(self, wanted: "ParameterMessage") -> "ParameterMessage":
        """A wish as a text: to ROS 2 1e3 is one here, and to its parameter files a number."""
        text = self._wishes[wanted.name]
        return _text_message(wanted.name, text) if _may_be_text(wanted, text) else wanted

    def _tell(
        self,
        node: str,
        what: str,
        names: Sequence[str],
        result: "SetParametersResult",
        before: str = "",
    ) -> bool:
        """Print a result as Lyrical does; whether it is a success.

        Args:
            node: Whose it is.
            what: What was set, with a place for whose.
            names: The parameters.
            result: What the node says.
            before: What stands before it.

        Raises:
            RefusedError: It is none, and nothing else was asked for.
        """
        what = what.format(f" of {node}" if self._names_nodes else "")
        if result.successful:
            line = _with_reason(f"{before}Set {what} successful", result.reason)
            self._told.tell(line, node, names, result.reason)
            return True
        text = _with_reason(f"{before}Setting {what} failed", result.reason)
        if not self._names_nodes and not self._are_several:
            raise RefusedError(text)
        self._told.tell(text, node, names, result.reason, successful=False)
        return False


def _message(name: str, text: str) -> "ParameterMessage":
    from teleopctl.interfaces import get_message
    from teleopctl.node import parameter_value_from_yaml

    message: type[ParameterMessage] = get_message("rcl_interfaces/msg/Parameter")
    return message(name=name, value=parameter_value_from_yaml(text))


def _text_message(name: str, text: str) -> "ParameterMessage":
    from teleopctl.node import Parameter

    return Parameter(name, value=text).to_parameter_msg()


def _may_be_text(wanted: "ParameterMessage", text: str) -> bool:
    from teleopctl.node import ParameterType

    return wanted.value.type == ParameterType.DOUBLE and "e" in text.lower() and "." not in text


def delete_parameter(
    node_name: Nodes,
    parameter_name: ParameterName,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Delete a parameter."""
    from teleopctl.node import Parameter

    told = Results(as_json=as_json)
    is_one = not is_pattern(node_name)
    nothing = Parameter(parameter_name).to_parameter_msg()
    with Parameters(timeout, service_timeout) as parameters:

        def delete(node: str) -> bool:
            result = parameters.set(node, [nothing])[parameter_name]
            of_node = "" if is_one else f" of {node}"
            if not result.successful:
                said = f"Deleting parameter{of_node} failed"
                raise RefusedError(_with_reason(said, result.reason))
            line = _with_reason(f"Deleted parameter{of_node} successfully", result.reason)
            told.tell(line, node, [parameter_name], result.reason)
            return True

        nodes = parameters.meant(node_name, include_hidden=include_hidden)
        all_well = with_each(nodes, delete, is_one=is_one)
    told.finish()
    return int(not all_well)


def _with_reason(text: str, reason: str) -> str:
    return f"{text}: {reason}" if reason else text
