"""``teleopctl param set``, ``delete``, ``dump``, ``load``, ``save`` and ``restore``."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import is_pattern
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.client import (
    Nodes,
    ParameterName,
    Parameters,
    ParameterServiceOptions,
    with_each,
)
from teleopctl.errors import NotFoundError, RefusedError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rcl_interfaces.msg import Parameter as ParameterMessage, SetParametersResult

    from teleopctl.cli.verbs.param.client import Parameters
    from teleopctl.node import ParameterFile


class Results:
    """Results of setting parameters, printed as text or JSON.

    Args:
        as_json: For a program.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._records: list[console.Json] = []

    def tell(
        self, line: str, node: str, names: Sequence[str], reason: str, *, successful: bool = True
    ) -> None:
        """Add a result; rejections are printed to stderr in any case.

        Args:
            line: What a person reads.
            node: Full name of the node.
            names: The parameters that were set together.
            reason: What the node says of it, or "".
            successful: Whether they have been set.
        """
        self._records.append(
            {"node": node, "parameters": list(names), "successful": successful, "reason": reason}
        )
        if not successful:
            console.flush()
            console.note(line)
        elif not self._as_json:
            console.out(line)

    def say(self, line: str) -> None:
        """Print a line, unless the output is JSON."""
        if not self._as_json:
            console.out(line)

    def finish(self) -> None:
        """Print the JSON document."""
        if self._as_json:
            console.out_json(self._records)


def set_parameter(
    node_name: Nodes,
    parameter_name: ParameterName,
    value: Annotated[str, Argument(help="The new value, as YAML.", complete="parameter_values")],
    more: Annotated[
        list[str] | None,
        Argument(help="More parameters, each with its value.", metavar="NAME VALUE..."),
    ] = None,
    atomic: Annotated[bool, Option("--atomic", help="Set all of them, or none.")] = False,
    *,
    options: ParameterServiceOptions,
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
    with options.client() as parameters:
        nodes = parameters.meant(node_name, include_hidden=options.include_hidden)
        setting = _Setting(parameters, nodes, wishes, told, is_pattern=is_pattern(node_name))
        status = setting.together() if atomic else setting.each()
    told.finish()
    return status


class _Setting:
    """Parameters of one or more nodes, to be set to the same values."""

    def __init__(
        self,
        parameters: "Parameters",
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

        def set_atomically(node: str) -> bool:
            answer = self._parameters.ask(node, "SetParametersAtomically", parameters=wanted)
            texts = [self._as_text(each) for each in wanted]
            if not answer.result.successful and texts != wanted:
                again = self._parameters.ask(node, "SetParametersAtomically", parameters=texts)
                answer = again if again.result.successful else answer
            how = "parameters{} atomically"
            return self._tell(node, how, list(self._wishes), answer.result)

        return int(not with_each(self._nodes, set_atomically, is_one=not self._names_nodes))

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
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Delete a parameter."""
    from teleopctl.node import Parameter

    told = Results(as_json=as_json)
    is_one = not is_pattern(node_name)
    nothing = Parameter(parameter_name).to_parameter_msg()
    with options.client() as parameters:

        def delete(node: str) -> bool:
            result = parameters.set(node, [nothing])[parameter_name]
            of_node = "" if is_one else f" of {node}"
            if not result.successful:
                said = f"Deleting parameter{of_node} failed"
                raise RefusedError(_with_reason(said, result.reason))
            line = _with_reason(f"Deleted parameter{of_node} successfully", result.reason)
            told.tell(line, node, [parameter_name], result.reason)
            return True

        nodes = parameters.meant(node_name, include_hidden=options.include_hidden)
        all_well = with_each(nodes, delete, is_one=is_one)
    told.finish()
    return int(not all_well)


def _with_reason(text: str, reason: str) -> str:
    return f"{text}: {reason}" if reason else text


NodesOrAll = Annotated[
    list[str] | None,
    Argument(
        help="The nodes, or patterns such as '/arm/*'; otherwise all.",
        metavar="NODE_NAME...",
        complete="nodes",
    ),
]


def dump_parameters(
    node_name: Nodes,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Print a node's parameters as a file.

    It is what --params-file and `teleopctl param load` read.
    """
    document: dict[str, Any] = {}
    with options.client() as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node, as_json=as_json))
            return True

        nodes = parameters.meant(node_name, include_hidden=options.include_hidden)
        all_well = with_each(nodes, add, is_one=not is_pattern(node_name))
    if as_json:
        console.out_json(document)
        return int(not all_well)
    from teleopctl.base import ros_yaml

    # It ends in an empty line, as ROS 2's does.
    console.out_text(ros_yaml.dump(document))
    return int(not all_well)


def save_parameters(
    parameter_file: Annotated[str, Argument(help="The file that is written.", metavar="FILE")],
    node_names: NodesOrAll = None,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Write the parameters of nodes to one file.

    `teleopctl param restore` sets them again, and --params-file starts a node with them.
    """
    from teleopctl.base import ros_yaml

    document: dict[str, Any] = {}
    with options.client() as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node))
            return True

        all_well = _with_each_of(parameters, node_names, add, include_hidden=options.include_hidden)
    if document:
        Path(parameter_file).write_text(ros_yaml.dump(document), encoding="utf-8")
    if as_json:
        console.out_json({"file": parameter_file, "nodes": list(document)})
    else:
        console.out_lines(f"Saved the parameters of {node}" for node in document)
    return int(not all_well)


def load_parameters(
    node_name: Nodes,
    parameter_file: Annotated[str, Argument(help="A parameter file.")],
    no_use_wildcard: Annotated[
        bool,
        Option("--no-use-wildcard", help="Leave out what is meant for several nodes (/**)."),
    ] = False,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Set parameters from a file.

    Of the file's sections, those count whose name fits the node.
    """
    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    told = Results(as_json=as_json)
    with options.client() as parameters:

        def load(node: str) -> bool:
            values = wanted.for_node(node, use_wildcard=not no_use_wildcard)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            return _load_values(parameters, node, values, told)

        nodes = parameters.meant(node_name, include_hidden=options.include_hidden)
        all_well = with_each(nodes, load, is_one=not is_pattern(node_name))
    told.finish()
    return int(not all_well)


def restore_parameters(
    parameter_file: Annotated[
        str, Argument(help="What `teleopctl param save` has written.", metavar="FILE")
    ],
    node_names: NodesOrAll = None,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Set the parameters of nodes from one file.

    Without names, those of all nodes that the file has a section for.
    """
    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    told = Results(as_json=as_json)
    with options.client() as parameters:

        def restore(node: str) -> bool:
            values = wanted.for_node(node)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            told.say(f"{node}:")
            return _load_values(parameters, node, values, told, indent="  ")

        names = node_names or _sections(wanted)
        all_well = _with_each_of(parameters, names, restore, include_hidden=options.include_hidden)
    told.finish()
    return int(not all_well)


def _sections(wanted: "ParameterFile") -> list[str]:
    return list(dict.fromkeys(name for name, _ in wanted.sections))


def _with_each_of(
    parameters: "Parameters",
    names: list[str] | None,
    do: "Callable[[str], bool]",
    *,
    include_hidden: bool,
) -> bool:
    """Do it with each node that is meant, all where none is named; whether all went well."""
    if not names:
        return with_each(parameters.nodes(include_hidden=include_hidden), do, is_one=False)
    is_one = len(names) == 1
    nodes: dict[str, None] = {}

    def find(name: str) -> bool:
        nodes.update(dict.fromkeys(parameters.meant(name, include_hidden=include_hidden)))
        return True

    all_found = with_each(names, find, is_one=is_one)
    return with_each(nodes, do, is_one=is_one and not is_pattern(names[0])) and all_found


# Any: YAML's values.
def _document(parameters: "Parameters", node: str, *, as_json: bool = False) -> dict[str, Any]:
    from teleopctl.node import parameter_document

    values = parameters.values(node, parameters.names(node))
    return parameter_document(node, values.items(), plain=as_json)


def _load_values(
    parameters: "Parameters",
    node: str,
    values: Mapping[str, Any],  # Any: YAML's values
    told: Results,
    indent: str = "",
) -> bool:
    """Set parameters of a node one by one, and print the results.

    Values that are null stay as they are. One that may not be changed and has the value already
    counts as set.

    Args:
        parameters: How to reach the node.
        node: Its full name.
        values: The values by name.
        told: Who says what became of it.
        indent: What each line begins with.

    Returns:
        Whether all are as the values say.

    Raises:
        UnavailableError: The node does not answer.
        TypeError: A value is none that parameters can have.
    """
    wanted = {message.name: message for message in _parameter_messages(parameters, node, values)}
    results = parameters.set(node, list(wanted.values()))
    refused = [name for name, result in results.items() if not result.successful]
    present = parameters.values(node, refused) if refused else {}
    all_well = True
    for name, result in results.items():
        reason = f": {result.reason}" if result.reason else ""
        if result.successful:
            line = f"{indent}Set parameter {name} successful{reason}"
            told.tell(line, node, [name], result.reason)
        elif name in present and present[name] == wanted[name].value:
            reason = "it has this value already"
            line = f"{indent}Set parameter {name} successful: {reason}"
            told.tell(line, node, [name], reason)
        else:
            all_well = False
            line = f"{indent}Set parameter {name} failed{reason}"
            told.tell(line, node, [name], result.reason, successful=False)
    return all_well


def _parameter_messages(
    parameters: "Parameters", node: str, values: Mapping[str, Any]
) -> "list[ParameterMessage]":
    from teleopctl.node import Parameter, ParameterType

    # An empty list of a file says nothing of its type; the parameter that is there does.
    empty = [name for name, value in values.items() if isinstance(value, list) and not value]
    present = parameters.values(node, empty) if empty else {}
    types = {name: ParameterType(value.type) for name, value in present.items()}
    return [
        Parameter(name, _list_type(types.get(name)), value).to_parameter_msg()
        for name, value in values.items()
        if value is not None
    ]


def _list_type(present: Any) -> Any:
    from teleopctl.node import ParameterType

    is_list = present is not None and present >= ParameterType.BYTE_ARRAY
    return present if is_list else None
