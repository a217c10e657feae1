"""YAML as ROS 2 parses it: the safe subset, with rcl's rules for plain scalars.

PyYAML follows YAML 1.1, in which a float needs a dot. ROS 2's parsers also accept ``1e-3``, which
is frequent in parameter files. A date stays text, since ROS 2 has no type for dates.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from teleopctl.base.budget import (
    DEEPEST_YAML,
    LONGEST_DOCUMENT,
    MOST_FROM_ALIASES,
    BudgetError,
    Tally,
)
from teleopctl.base.typed import Any, TypeAlias
from teleopctl.errors import InvalidFileError, TeleopctlError

_BASE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_STANDARD = "tag:yaml.org,2002:"
_TIMESTAMP = f"{_STANDARD}timestamp"
_MERGE = f"{_STANDARD}merge"
_INTEGER = f"{_STANDARD}int"
_MAPPING = f"{_STANDARD}map"

_Entry: TypeAlias = tuple[yaml.Node, yaml.Node]

# In digits. Python parses an integer in quadratic time.
_LONGEST_INTEGER = 100


class SafeLoader(_BASE):  # type: ignore[misc]
    """PyYAML safe loader with limits on depth and alias expansion; raises YAML errors only.

    Args:
        text: One YAML document, or several.

    Raises:
        yaml.YAMLError: See `check_size`.
    """

    def __init__(self, text: str) -> None:
        check_size(text)
        super().__init__(text)

    # Any: values of YAML.
    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct a value; invalid explicit tags such as ``!!int`` are YAML errors."""
        if node.tag == _INTEGER and len(node.value) > _LONGEST_INTEGER:
            raise yaml.constructor.ConstructorError(
                None, None, "an integer of too many digits", node.start_mark
            )
        try:
            return super().construct_object(node, deep)
        except (ArithmeticError, ValueError, LookupError, AttributeError, TypeError) as error:
            # Raised by PyYAML's constructors if a value does not fit its tag.
            tag = node.tag.replace(_STANDARD, "!!")
            value = repr(node.value[:_LONGEST_INTEGER]) if isinstance(node.value, str) else "this"
            raise yaml.constructor.ConstructorError(
                None, None, f"{value} is no {tag}", node.start_mark
            ) from error


class RosLoader(SafeLoader):
    """YAML loader with ROS 2's rules for floats (``1e-3``), and with dates as text.

    Args:
        text: One YAML document.

    Raises:
        yaml.YAMLError: See `check_size`.
    """

    yaml_implicit_resolvers = {  # noqa: RUF012 -- PyYAML reads this attribute of the class
        first: [(tag, pattern) for tag, pattern in resolvers if tag != _TIMESTAMP]
        for first, resolvers in _BASE.yaml_implicit_resolvers.items()
    }


class _RosDumper(yaml.SafeDumper):
    """YAML dumper for `RosLoader`: quotes texts that the loader would read as numbers."""


for _class in (RosLoader, _RosDumper):
    _class.add_implicit_resolver(
        "tag:yaml.org,2002:float",
        re.compile(r"^[-+]?[0-9][0-9_]*(?:\.[0-9_]*)?[eE][-+]?[0-9]+$"),
        list("-+0123456789"),
    )


class _Collection:
    """List or mapping whose end is not reached: number of values and characters, and depth."""

    def __init__(self, anchor: str | None) -> None:
        self.anchor = anchor
        self.size = 1
        self.characters = 0
        self.depth = 0


def check_size(text: str) -> None:
    """Raise a YAMLError for YAML text that is nested too deep or whose aliases expand too far.

    Checks the parser's events before any value is constructed, since the constructor, and most code
    that reads the result, is recursive.

    Raises:
        yaml.YAMLError: The text is nested too deep, an alias is inside its own anchor, aliases
            expand to more than the limits in `base.budget`, or the text is not YAML.
    """
    anchors: dict[str, tuple[int, int, int] | None] = {}
    pending = [_Collection(None)]
    values = Tally("values", MOST_FROM_ALIASES)
    texts = Tally("characters", LONGEST_DOCUMENT)
    for event in yaml.parse(text, Loader=_BASE):
        size, characters, depth = 1, 0, 0
        if isinstance(event, yaml.CollectionStartEvent):
            pending.append(_Collection(event.anchor))
            if event.anchor:
                anchors[event.anchor] = None
            _check_depth(len(pending), event)
            continue
        if isinstance(event, yaml.CollectionEndEvent):
            ended = pending.pop()
            anchor, size, depth = ended.anchor, ended.size, ended.depth + 1
            characters = ended.characters
        elif isinstance(event, yaml.ScalarEvent):
            anchor, characters = event.anchor, len(event.value)
        elif isinstance(event, yaml.AliasEvent):
            anchor = None
            # PyYAML's composer refuses an unknown alias.
            known = anchors.get(str(event.anchor), (0, 0, 0))
            if known is None:
                raise _refusal(f"'*{event.anchor}' refers to a value that contains it", event)
            size, characters, depth = known
            try:
                values.add(size)
                texts.add(characters)
            except BudgetError as error:
                raise _refusal(f"aliases expand to {error}", event) from error
            _check_depth(len(pending) + depth, event)
        else:
            continue
        if anchor:
            anchors[anchor] = (size, characters, depth)
        pending[-1].size += size
        pending[-1].characters += characters
        pending[-1].depth = max(pending[-1].depth, depth)


def _check_depth(depth: int, event: yaml.Event) -> None:
    if depth > DEEPEST_YAML:
        raise _refusal(f"nested more than {DEEPEST_YAML} deep", event)


def _refusal(reason: str, event: yaml.Event) -> yaml.YAMLError:
    mark: Any = event.start_mark  # libyaml's marks are no `yaml.Mark`
    return yaml.composer.ComposerError(None, None, reason, mark)


@contextlib.contextmanager
def faults_of(path: Path, kind: type[TeleopctlError] = InvalidFileError) -> Iterator[None]:
    """Convert YAML errors in a ``with`` block into errors with file, line and reason.

    Args:
        path: Path of the file whose text is parsed in the block.
        kind: Class of the raised error.

    Raises:
        TeleopctlError: A `yaml.YAMLError` was raised in the block. The error is of class ``kind``.
    """
    try:
        yield
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f":{mark.line + 1}" if mark is not None else ""
        reason = getattr(error, "problem", None) or error
        raise kind(f"{path}{line}: not YAML: {reason}") from error


# Any, here and below: values of YAML.
def load(text: str) -> Any:
    """Parse one YAML document by ROS 2's rules for floats and dates, and return its Python value.

    Raises:
        yaml.YAMLError: The text is not YAML; ``problem_mark`` is the place.
    """
    return yaml.load(text, Loader=RosLoader)  # noqa: S506 (derived from the safe loader)


def safe_load(text: str) -> Any:
    """Parse one YAML 1.1 document as PyYAML does, and return its Python value.

    Raises:
        yaml.YAMLError: The text is not YAML.
    """
    return yaml.load(text, Loader=SafeLoader)  # noqa: S506 (derived from the safe loader)


def compose(text: str) -> yaml.Node | None:
    """Parse one YAML document into nodes, whose marks have line numbers; None if it is empty.

    Raises:
        yaml.YAMLError: The text is not YAML.
    """
    node: yaml.Node | None = RosLoader(text).get_single_node()
    return node


def values_below(text: str, name: str) -> Iterator[tuple[yaml.Node, Any]]:
    """Yield YAML node and Python value of each value below a key, at any depth.

    Mappings, and lists of mappings, are no values themselves.

    Args:
        text: One YAML document.
        name: Key, which may occur at any depth and several times.

    Raises:
        yaml.YAMLError: The text is not YAML.
    """
    loader = RosLoader(text)
    # Nodes to visit, and whether they are below the key.
    pending = [(loader.get_single_node(), False)]
    while pending:
        node, is_below = pending.pop()
        if isinstance(node, yaml.MappingNode) and node.tag == _MAPPING:
            pending += [
                (value, is_below or key.value == name) for key, value in reversed(node.value)
            ]
        elif isinstance(node, yaml.SequenceNode) and _are_mappings(node.value):
            pending += [(item, is_below) for item in reversed(node.value)]
        elif is_below:
            yield node, loader.construct_object(node, deep=True)


def _are_mappings(nodes: Sequence[yaml.Node]) -> bool:
    return bool(nodes) and all(isinstance(node, yaml.MappingNode) for node in nodes)


def load_value(text: str) -> Any:
    """Return a parameter value given as YAML text; text that starts with ``<``, as URDF, as it is.

    A text that starts with ``<`` is a robot description and is returned as it is.

    Raises:
        yaml.YAMLError: The text is not YAML.
    """
    return text if text.lstrip().startswith("<") else load(text)


def dump(document: Any) -> str:
    """Return a value as a YAML document with sorted keys."""
    return yaml.dump(document, Dumper=_RosDumper, allow_unicode=True)


class _MergingLoader(RosLoader):
    """`RosLoader` that merges the mappings of a repeated key."""

    def construct_mapping(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct a mapping in which repeated keys are merged."""
        if isinstance(node, yaml.MappingNode):
            node.value = _merged(node.value)
        return super().construct_mapping(node, deep)


def _merged(entries: Sequence[_Entry]) -> list[_Entry]:
    """Join the mappings of a repeated key; of other values the last one is used."""
    merged: dict[object, _Entry] = {}
    for index, (key, value) in enumerate(entries):
        is_plain = isinstance(key, yaml.ScalarNode) and key.tag != _MERGE
        name = (key.tag, key.value) if is_plain else index
        if name in merged:
            before = merged[name][1]
            if isinstance(before, yaml.MappingNode) and isinstance(value, yaml.MappingNode):
                value = yaml.MappingNode(
                    value.tag, [*before.value, *value.value], before.start_mark, value.end_mark
                )
        merged[name] = (key, value)
    return list(merged.values())


def load_merged(text: str) -> Any:
    """Parse a YAML document as rcl reads parameter files: mappings of repeated keys are merged.

    The mappings of equal keys are merged, at the place of the first. For contradicting values the
    later one is used.

    Raises:
        yaml.YAMLError: The text is not YAML; ``problem_mark`` is the place.
    """
    return yaml.load(text, Loader=_MergingLoader)  # noqa: S506 (derived from the safe loader)
