"""Parameter files: ``NODE: ros__parameters: …``, with wildcards and nested namespaces.

Source: rcl's parameter file format. A section's name is a node's full name, with or without the
leading slash; ``*`` matches one part of a name and ``**`` any number of parts. Nested values
become dotted names. Repeated names are merged.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from teleopctl.base.files import read_text
from teleopctl.base.printable import shortened
from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.errors import InvalidFileError

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage

_PARAMETERS = "ros__parameters"
_EVERY_NODE = "/**"


class ParameterFile(NamedTuple):
    """Contents of a parameter file: sections of node names with their parameters.

    Attributes:
        sections: Pairs of a section's name, with its leading slash, and its flat parameters.
    """

    # Any, here and below: YAML's values, which `Parameter` checks.
    sections: tuple[tuple[str, dict[str, Any]], ...]

    def for_node(
        self, full_name: str, use_wildcard: bool = True, *, names_win: bool = False
    ) -> dict[str, Any]:
        """Return the parameters that apply to a node; later sections override earlier ones.

        Args:
            full_name: Full name of the node.
            use_wildcard: Whether sections with wildcards apply.
            names_win: Whether sections without a wildcard override those with one, wherever they
                stand, as ``launch_ros`` has it for components.
        """
        result: dict[str, Any] = {}
        sections = self.sections
        if names_win:
            sections = tuple(sorted(sections, key=lambda section: "*" not in section[0]))
        for pattern, parameters in sections:
            if (use_wildcard or "*" not in pattern) and _matches(pattern, full_name):
                result.update(parameters)
        return result


@functools.cache
def _pattern(section: str) -> re.Pattern[str]:
    parts = [
        "(?:/[^/]+)*" if part == "**" else "/" + re.escape(part).replace(r"\*", "[^/]*")
        for part in section.strip("/").split("/")
    ]
    return re.compile("".join(parts) + r"\Z")


def _matches(section: str, full_name: str) -> bool:
    return _pattern(section).match(full_name) is not None


# Any: as above.
def flatten_parameters(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted parameter names and their values from nested mappings.

    A list of mappings counts as one mapping, as in ROS 2's parser: the files of gpio_controllers
    have ``- interfaces: […]`` below the name of a GPIO.
    """
    for key, value in values.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            yield from flatten_parameters(value, f"{name}.")
        elif isinstance(value, list) and value and all(isinstance(i, Mapping) for i in value):
            for item in value:
                yield from flatten_parameters(item, f"{name}.")
        else:
            yield name, value


def _sections(
    tree: Mapping[str, Any], path: Path, prefix: str = ""
) -> Iterator[tuple[str, dict[str, Any]]]:
    for key, value in tree.items():
        name = f"{prefix}/{str(key).strip('/')}"
        if not isinstance(value, Mapping):
            raise InvalidFileError(
                f"{path}: '{key}' holds {value!r} where a section with '{_PARAMETERS}' is expected"
            )
        if _PARAMETERS in value:
            parameters = value[_PARAMETERS]
            if parameters is None:
                parameters = {}
            if not isinstance(parameters, Mapping):
                raise InvalidFileError(
                    f"{path}: '{_PARAMETERS}' of '{key}' must be a mapping of names to values"
                )
            yield name, dict(flatten_parameters(parameters))
        rest = {inner: content for inner, content in value.items() if inner != _PARAMETERS}
        if rest:
            yield from _sections(rest, path, name)


def read_parameter_file(path: Path, *, may_be_plain: bool = False) -> ParameterFile:
    """Read, check and return a parameter file; raise InvalidFileError if it is invalid.

    Args:
        path: Path of the file.
        may_be_plain: Whether a file without any ``ros__parameters`` has the parameters of every
            node, as ``launch_ros`` takes it for components.

    Raises:
        InvalidFileError: The file cannot be read, is not YAML or has another layout.
    """
    from teleopctl.base import ros_yaml
    from teleopctl.node.values.parameter import parameter_value_problem

    text = read_text(path)
    with ros_yaml.faults_of(path):
        tree = ros_yaml.load_merged(text)
    if tree is None:
        return ParameterFile(())
    if not isinstance(tree, Mapping):
        raise InvalidFileError(f"{path}: a mapping of node names is expected at the top")
    if may_be_plain and not _has_section(tree):
        tree = {_EVERY_NODE: {_PARAMETERS: tree}}
    sections = tuple(_sections(tree, path))
    for _, parameters in sections:
        for name, value in parameters.items():
            reason = parameter_value_problem(value)
            if reason is not None:
                line = _line_of_fault(text)
                raise InvalidFileError(
                    f"{path}{line}: parameter '{name}' cannot be {shortened(str(value))}: {reason}."
                )
    return ParameterFile(sections)


# Any: as above.
def _has_section(tree: Mapping[str, Any]) -> bool:
    return _PARAMETERS in tree or any(
        isinstance(value, Mapping) and _has_section(value) for value in tree.values()
    )


def _line_of_fault(text: str) -> str:
    """Line of the first value that no parameter can have, as ``:line``; empty if unknown."""
    from teleopctl.base import ros_yaml
    from teleopctl.node.values.parameter import parameter_value_problem

    for node, value in ros_yaml.values_below(text, _PARAMETERS):
        if parameter_value_problem(value) is not None:
            return f":{node.start_mark.line + 1}"
    return ""


def read_parameter_lines(path: Path) -> ParameterFile:
    """Read a parameter file; return it with the line number of each parameter as its value.

    Raises:
        InvalidFileError: The file cannot be read or is not YAML.
    """
    import yaml

    from teleopctl.base import ros_yaml

    text = read_text(path)
    with ros_yaml.faults_of(path):
        top = ros_yaml.compose(text)
    found: list[tuple[str, dict[str, Any]]] = []
    # Nodes to visit: the name of the section so far, and the mapping.
    pending: list[tuple[str, yaml.Node | None]] = [("", top)]
    while pending:
        name, node = pending.pop(0)
        for key, value in _mapping_entries(node):
            if key.value == _PARAMETERS:
                found.append((name, dict(_lines_below(value, ""))))
            else:
                pending.append((f"{name}/{key.value.strip('/')}", value))
    return ParameterFile(tuple(found))


def find_parameter_line(files: Iterable[str | Path], node: str, parameter: str) -> str:
    """Return ``FILE:LINE`` of the last file that sets a node's parameter; empty if none does.

    Args:
        files: Paths of parameter files; those that cannot be read are left out.
        node: Full name of the node.
        parameter: Dotted name of the parameter.
    """
    for file in reversed(list(files)):
        try:
            lines = read_parameter_lines(Path(file)).for_node(node)
        except InvalidFileError:
            continue
        if parameter in lines:
            return place_in_file(file, lines[parameter])
    return ""


_COPY_OF = "# The lines above are those of "


def copy_mark(original: Path) -> str:
    """Return a comment for the end of a copy of a parameter file, for `place_in_file`.

    Args:
        original: Path of the file, which has the same number of lines.
    """
    return f"{_COPY_OF}{original}\n"


def place_in_file(file: str | Path, line: int) -> str:
    """Return ``FILE:LINE``, of the original file for a line above a `copy_mark`.

    Args:
        file: Path of a parameter file.
        line: Number of the line, from 1.
    """
    with suppress(InvalidFileError):
        for text in read_text(Path(file)).splitlines()[line:]:
            if text.startswith(_COPY_OF):
                return f"{text.removeprefix(_COPY_OF)}:{line}"
    return f"{file}:{line}"


# Any: nodes of YAML; its module is imported only by those who read files.
def _mapping_entries(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the pairs of nodes of a mapping node with plain keys, also of merged mappings (<<)."""
    if not isinstance(node.value if node is not None else None, list) or node.id != "mapping":
        return
    for key, value in node.value:
        if key.tag.endswith(":merge"):
            for merged in value.value if value.id == "sequence" else [value]:
                yield from _mapping_entries(merged)
        elif key.id == "scalar":
            yield key, value


def _lines_below(node: Any, prefix: str) -> Iterator[tuple[str, int]]:
    for key, value in _mapping_entries(node):
        name = f"{prefix}{key.value}"
        items = value.value if value.id == "sequence" else [value]
        if items and all(item.id == "mapping" for item in items):
            for item in items:
                yield from _lines_below(item, f"{name}.")
        else:
            yield name, key.start_mark.line + 1


def parameter_messages(
    path: str | Path,
    use_wildcard: bool = False,
    target_nodes: Sequence[str] | None = None,
    namespace: str = "",
) -> dict[str, ParameterMessage]:
    """Return the parameters of a file as ``Parameter`` messages, by name.

    Args:
        path: Path of the parameter file.
        use_wildcard: Whether sections with wildcards (``/**``, ``/*/name``, ``/**/name``) are used
            too; other sections override them.
        target_nodes: Names of the nodes whose sections are used; all sections if empty.
        namespace: Prefix of all parameter names, without the dot.

    Returns:
        A ``rcl_interfaces/msg/Parameter`` for each dotted name.

    Raises:
        InvalidFileError: The file cannot be read or is no parameter file, or a node has no section.
        TypeError: No parameter type can hold a value.
    """
    from teleopctl.node.values.parameter import Parameter

    sections = read_parameter_file(Path(path)).sections
    targets = [f"/{name.strip('/')}" for name in target_nodes or ()]
    chosen = {
        name
        for name, _ in sections
        if (not targets or any(_is_meant(name, target) for target in targets))
        and (use_wildcard or "*" not in name)
    }
    missing = [t for t in targets if not any(_is_meant(name, t) for name in chosen)]
    if missing:
        raise InvalidFileError(
            "Param file does not contain selected parameters: "
            f"{path} has none for {', '.join(missing)}",
            hint=f"It has some for {', '.join(name for name, _ in sections)}.",
        )
    values: dict[str, Any] = {}
    # Sections for all nodes first, then those with wildcards: later values override earlier ones.
    for name, parameters in sorted(sections, key=lambda s: (s[0] != _EVERY_NODE, "*" not in s[0])):
        if name in chosen:
            values.update(parameters)
    prefix = f"{namespace}." if namespace else ""
    return {
        prefix + name: Parameter(prefix + name, value=value).to_parameter_msg()
        for name, value in values.items()
    }


def _is_meant(section: str, node: str) -> bool:
    """Whether the name of a section, with ``*`` and ``**``, matches a node."""
    namespace, _, name = node.rpartition("/")
    if section in (_EVERY_NODE, node):
        return True
    if namespace and section == f"{_EVERY_NODE}/{name}":
        return True
    return namespace.count("/") == 1 and section == f"/*/{name}"


# Any: a YAML value of any type; the message is a ParameterValue.
def plain_parameter_value(value: Any) -> Any:
    """Return the YAML value of a ``ParameterValue``, bytes as numbers; None if not set."""
    from teleopctl.interfaces import parameter_value_to_python

    found = parameter_value_to_python(value)
    if isinstance(found, list):
        return [element[0] if isinstance(element, bytes) else element for element in found]
    return found


def parameter_document(
    node_name: str, parameters: Iterable[tuple[str, Any]], *, plain: bool = False
) -> dict[str, Any]:
    """Return the contents of a parameter file with the parameters of one node.

    Args:
        node_name: Full name of the node.
        parameters: Pairs of parameter name and ``ParameterValue``, sorted by name.
        plain: Whether to convert bytes to numbers, for JSON.
    """
    from teleopctl.interfaces import parameter_value_to_python

    tree: dict[str, Any] = {}
    for name, value in parameters:
        convert = plain_parameter_value if plain else parameter_value_to_python
        _put(tree, name.split("."), convert(value))
    return {node_name: {_PARAMETERS: tree}}


def _put(tree: dict[str, Any], path: list[str], value: object) -> None:
    for depth, part in enumerate(path[:-1]):
        branch = tree.setdefault(part, {})
        if not isinstance(branch, dict):
            # Another parameter has the name of this prefix: keep the dots of this one.
            tree[".".join(path[depth:])] = value
            return
        tree = branch
    tree[path[-1]] = value
