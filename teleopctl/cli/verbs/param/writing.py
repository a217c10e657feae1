"""``teleopctl param set``, ``delete``, ``dump``, ``load``, ``save`` and ``restore``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Mapping, Sequence
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import is_pattern
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.client import (
    GraphParameters,
    Nodes,
    ParameterName,
    ParameterServiceOptions,
    for_each_node,
)
from teleopctl.errors import NotFoundError, RefusedError, UsageError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Callable

    from rcl_interfaces.msg import Parameter as ParameterMessage, SetParametersResult

    from teleopctl.cli.verbs.param.client import GraphParameters
    from teleopctl.node import ParameterFile


class ParameterResults:
    """Results of setting parameters, printed at once as text or at the end as JSON.

    Args:
        as_json: Whether the output is JSON.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._records: list[console.Json] = []

    def add(
        self, line: str, node: str, names: Sequence[str], reason: str, *, successful: bool = True
    ) -> None:
        """Record a result, and print its line: to stderr if rejected, else unless JSON is printed.

        Args:
            line: Line of the text output.
            node: Full name of the node.
            names: Names of the parameters that were set together.
            reason: Reason in the node's response; may be empty.
            successful: Whether the parameters were set.
        """
        self._records.append(
            {"node": node, "parameters": list(names), "successful": successful, "reason": reason}
        )
        if not successful:
            console.flush()
            console.note(line)
        elif not self._as_json:
            console.out(line)

    def print_line(self, line: str) -> None:
        """Print a line without a result, unless the output is JSON."""
        if not self._as_json:
            console.out(line)

    def print_json(self) -> None:
        """Print the recorded results, if the output is JSON."""
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
    """Set parameters of one node or of matching nodes, each on its own or all atomically.

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
    values = dict(zip(words[::2], words[1::2], strict=True))
    results = ParameterResults(as_json=as_json)
    with options.client() as parameters:
        nodes = parameters.matching_nodes(node_name, include_hidden=options.include_hidden)
        setting = _Setting(parameters, nodes, values, results, is_pattern=is_pattern(node_name))
        status = setting.set_atomically() if atomic else setting.set_each()
    results.print_json()
    return status


class _Setting:
    """Parameters of one or more nodes, to be set to the same values."""

    def __init__(
        self,
        parameters: "GraphParameters",
        nodes: Sequence[str],
        values: dict[str, str],
        results: ParameterResults,
        *,
        is_pattern: bool,
    ) -> None:
        self._parameters = parameters
        self._nodes = nodes
        self._values = values
        self._results = results
        self._names_nodes = is_pattern
        self._are_several = len(values) > 1

    def set_atomically(self) -> int:
        """Set the parameters of each node atomically; return the exit status."""
        wanted = [_message(name, text) for name, text in self._values.items()]

        def set_of_node(node: str) -> bool:
            answer = self._parameters.call(node, "SetParametersAtomically", parameters=wanted)
            texts = [self._as_text(each) for each in wanted]
            if not answer.result.successful and texts != wanted:
                again = self._parameters.call(node, "SetParametersAtomically", parameters=texts)
                answer = again if again.result.successful else answer
            how = "parameters{} atomically"
            return self._add_result(node, how, list(self._values), answer.result)

        return int(not for_each_node(self._nodes, set_of_node, is_one=not self._names_nodes))

    def set_each(self) -> int:
        """Set the parameters of each node one by one; return the exit status."""

        def set_of_node(node: str) -> bool:
            all_succeeded = True
            for name, result in self._set(node).items():
                before = f"{name}: " if self._are_several else ""
                all_succeeded &= self._add_result(node, "parameter{}", [name], result, before)
            return all_succeeded

        return int(not for_each_node(self._nodes, set_of_node, is_one=not self._names_nodes))

    def _set(self, node: str) -> "dict[str, SetParametersResult]":
        wanted = [_message(name, text) for name, text in self._values.items()]
        results = dict(self._parameters.set(node, wanted))
        refused = [each for each in wanted if not results[each.name].successful]
        texts = [text for each in refused if (text := self._as_text(each)) != each]
        if texts:
            again = self._parameters.set(node, texts)
            results |= {name: result for name, result in again.items() if result.successful}
        return results

    def _as_text(self, wanted: "ParameterMessage") -> "ParameterMessage":
        """Return a parameter as a string if its value, as 1e3, is one in ROS 2's ``param set``."""
        text = self._values[wanted.name]
        return _text_message(wanted.name, text) if _may_be_text(wanted, text) else wanted

    def _add_result(
        self,
        node: str,
        what: str,
        names: Sequence[str],
        result: "SetParametersResult",
        before: str = "",
    ) -> bool:
        """Print a result in the format of Lyrical; return whether it is a success.

        Args:
            node: Full name of the node.
            what: Text for what was set, with a placeholder for the node.
            names: Names of the parameters.
            result: Result in the node's response.
            before: Prefix of the line.

        Raises:
            RefusedError: The only requested change was rejected.
        """
        what = what.format(f" of {node}" if self._names_nodes else "")
        if result.successful:
            line = _with_reason(f"{before}Set {what} successful", result.reason)
            self._results.add(line, node, names, result.reason)
            return True
        text = _with_reason(f"{before}Setting {what} failed", result.reason)
        if not self._names_nodes and not self._are_several:
            known = self._parameters.names(node)
            hint = None if names[0] in known else did_you_mean(names[0], known)
            raise RefusedError(text, hint=hint)
        self._results.add(text, node, names, result.reason, successful=False)
        return False


def _message(name: str, text: str) -> "ParameterMessage":
    from teleopctl.interfaces import get_message, scalar_parameter_value

    message: type[ParameterMessage] = get_message("rcl_interfaces/msg/Parameter")
    value = scalar_parameter_value(text)
    if value is None:
        from teleopctl.node import parameter_value_from_yaml

        value = parameter_value_from_yaml(text)
    return message(name=name, value=value)


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
    """Delete a parameter of one node or of matching nodes."""
    from teleopctl.node import Parameter

    results = ParameterResults(as_json=as_json)
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
            results.add(line, node, [parameter_name], result.reason)
            return True

        nodes = parameters.matching_nodes(node_name, include_hidden=options.include_hidden)
        all_succeeded = for_each_node(nodes, delete, is_one=is_one)
    results.print_json()
    return int(not all_succeeded)


def _with_reason(text: str, reason: str) -> str:
    return f"{text}: {reason}" if reason else text


NodesOrAll = Annotated[
    list[str] | None,
    Argument(
        help="Nodes, or patterns such as '/arm/*'; by default all.",
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
    """Print the parameters of one node or of matching nodes as a parameter file.

    The output is a file for --params-file and `teleopctl param load`.
    """
    document: dict[str, Any] = {}
    with options.client() as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node, as_json=as_json))
            return True

        nodes = parameters.matching_nodes(node_name, include_hidden=options.include_hidden)
        all_succeeded = for_each_node(nodes, add, is_one=not is_pattern(node_name))
    if as_json:
        console.out_json(document)
        return int(not all_succeeded)
    from teleopctl.base import ros_yaml

    # The output ends with an empty line, as in ROS 2.
    console.out_text(ros_yaml.dump(document))
    return int(not all_succeeded)


def save_parameters(
    parameter_file: Annotated[str, Argument(help="The file that is written.", metavar="FILE")],
    node_names: NodesOrAll = None,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Write the parameters of the named nodes, or of all nodes, to a parameter file.

    `teleopctl param restore` sets them again; --params-file starts a node with them.
    """
    from teleopctl.base import ros_yaml

    document: dict[str, Any] = {}
    with options.client() as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node))
            return True

        all_succeeded = _with_each_of(
            parameters, node_names, add, include_hidden=options.include_hidden
        )
    if document:
        from pathlib import Path

        Path(parameter_file).write_text(ros_yaml.dump(document), encoding="utf-8")
    if as_json:
        console.out_json({"file": parameter_file, "nodes": list(document)})
    else:
        console.out_lines(f"Saved the parameters of {node}" for node in document)
    return int(not all_succeeded)


def load_parameters(
    node_name: Nodes,
    parameter_file: Annotated[str, Argument(help="A parameter file.")],
    no_use_wildcard: Annotated[
        bool,
        Option("--no-use-wildcard", help="Ignore parameters for several nodes (/**)."),
    ] = False,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Set the parameters of a node to the values in a parameter file.

    Only sections of the file whose name matches the node are used.
    """
    from pathlib import Path

    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    results = ParameterResults(as_json=as_json)
    with options.client() as parameters:

        def load(node: str) -> bool:
            values = wanted.for_node(node, use_wildcard=not no_use_wildcard)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            return _load_values(parameters, node, values, results)

        nodes = parameters.matching_nodes(node_name, include_hidden=options.include_hidden)
        all_succeeded = for_each_node(nodes, load, is_one=not is_pattern(node_name))
    results.print_json()
    return int(not all_succeeded)


def restore_parameters(
    parameter_file: Annotated[
        str, Argument(help="A file written by `teleopctl param save`.", metavar="FILE")
    ],
    node_names: NodesOrAll = None,
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Set parameters of the named nodes, or of all in a file, to the values in the file.

    Without names, sets the parameters of all nodes in the file.
    """
    from pathlib import Path

    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    results = ParameterResults(as_json=as_json)
    with options.client() as parameters:

        def restore(node: str) -> bool:
            values = wanted.for_node(node)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            results.print_line(f"{node}:")
            return _load_values(parameters, node, values, results, indent="  ")

        names = node_names or _sections(wanted)
        all_succeeded = _with_each_of(
            parameters, names, restore, include_hidden=options.include_hidden
        )
    results.print_json()
    return int(not all_succeeded)


def _sections(wanted: "ParameterFile") -> list[str]:
    return list(dict.fromkeys(name for name, _ in wanted.sections))


def _with_each_of(
    parameters: "GraphParameters",
    names: list[str] | None,
    do: "Callable[[str], bool]",
    *,
    include_hidden: bool,
) -> bool:
    """Call a function for each node that names or patterns select, or for all without names.

    Returns:
        Whether all calls succeeded.
    """
    if not names:
        return for_each_node(parameters.nodes(include_hidden=include_hidden), do, is_one=False)
    is_one = len(names) == 1
    nodes: dict[str, None] = {}

    def add_matching(name: str) -> bool:
        nodes.update(dict.fromkeys(parameters.matching_nodes(name, include_hidden=include_hidden)))
        return True

    all_found = for_each_node(names, add_matching, is_one=is_one)
    return for_each_node(nodes, do, is_one=is_one and not is_pattern(names[0])) and all_found


# Any: values as in YAML.
def _document(parameters: "GraphParameters", node: str, *, as_json: bool = False) -> dict[str, Any]:
    from teleopctl.node import parameter_document

    values = parameters.values(node, parameters.names(node))
    return parameter_document(node, values.items(), plain=as_json)


def _load_values(
    parameters: "GraphParameters",
    node: str,
    values: Mapping[str, Any],  # Any: values as in YAML
    results: ParameterResults,
    indent: str = "",
) -> bool:
    """Set parameters of a node one by one, and print the results.

    Null values are skipped. A rejected parameter that has the value already counts as set.

    Args:
        parameters: Client of the node's parameter services.
        node: Full name of the node.
        values: Values by parameter name.
        results: Output of the results.
        indent: Indent of each line.

    Returns:
        Whether all parameters have the given values.

    Raises:
        UnavailableError: The node does not respond.
        TypeError: A value has a type that parameters cannot have.
    """
    wanted = {message.name: message for message in _parameter_messages(parameters, node, values)}
    answers = parameters.set(node, list(wanted.values()))
    refused = [name for name, result in answers.items() if not result.successful]
    present = parameters.values(node, refused) if refused else {}
    all_succeeded = True
    for name, result in answers.items():
        reason = f": {result.reason}" if result.reason else ""
        if result.successful:
            line = f"{indent}Set parameter {name} successful{reason}"
            results.add(line, node, [name], result.reason)
        elif name in present and present[name] == wanted[name].value:
            reason = "it has this value already"
            line = f"{indent}Set parameter {name} successful: {reason}"
            results.add(line, node, [name], reason)
        else:
            all_succeeded = False
            line = f"{indent}Set parameter {name} failed{reason}"
            results.add(line, node, [name], result.reason, successful=False)
    return all_succeeded


def _parameter_messages(
    parameters: "GraphParameters", node: str, values: Mapping[str, Any]
) -> "list[ParameterMessage]":
    from teleopctl.node import Parameter, ParameterType

    # An empty list in a file has no element type, so the type of the present parameter is used.
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
