"""YAML of ours that is checked as it is read: every mistake with its file and line."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from teleopctl.base.printable import shortened
from teleopctl.base.ros_yaml import RosLoader, faults_of
from teleopctl.errors import InvalidDescriptionError, did_you_mean


@dataclass(frozen=True)
class YamlEntry:
    """A value in a YAML file, with its place.

    Attributes:
        path: The file.
        name: What it is called in messages.
        node: Where it stands.
        value: What it is.
    """

    path: Path
    name: str
    node: yaml.Node
    # Any: whatever YAML has; each method below says what it may be.
    value: Any

    @property
    def _is(self) -> str:
        """What it is, for messages."""
        return f"is {shortened(repr(self.value))}"

    def refuse(self, words: str) -> InvalidDescriptionError:
        """Return an error about this value."""
        line = self.node.start_mark.line + 1
        return InvalidDescriptionError(f"{self.path}:{line}: {self.name} {words}")

    def entries(self, known: Iterable[str] | None = None) -> dict[str, YamlEntry]:
        """Return the entries of a mapping; raise for unknown keys.

        Raises:
            InvalidDescriptionError: It is no mapping, or has a key that is not known.
        """
        if not isinstance(self.node, yaml.MappingNode):
            raise self.refuse(f"should be a mapping, {self._is}")
        allowed = None if known is None else list(known)
        found: dict[str, YamlEntry] = {}
        for key, node in self.node.value:
            name = str(key.value)
            entry = YamlEntry(self.path, f"'{name}'", node, self.value.get(_key(key, self.value)))
            if allowed is not None and name not in allowed:
                line = key.start_mark.line + 1
                raise InvalidDescriptionError(
                    f"{self.path}:{line}: {self.name} has no '{name}'",
                    hint=did_you_mean(name, allowed) or f"It may have: {', '.join(allowed)}",
                )
            if name in found:
                raise entry.refuse("stands there twice")
            found[name] = entry
        return found

    def items(self) -> list[YamlEntry]:
        """Return the entries of a list.

        Raises:
            InvalidDescriptionError: It is none.
        """
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.refuse(f"should be a list, {self._is}")
        return [
            YamlEntry(self.path, f"{self.name}[{number}]", node, value)
            for number, (node, value) in enumerate(zip(self.node.value, self.value, strict=True))
        ]

    def text(self) -> str:
        """Return the value as text.

        Raises:
            InvalidDescriptionError: It is none, or empty.
        """
        if not isinstance(self.value, str) or not self.value:
            raise self.refuse(f"should be a text, {self._is}")
        return self.value

    def flag(self) -> bool:
        """Return the value as a truth value.

        Raises:
            InvalidDescriptionError: It is neither.
        """
        if not isinstance(self.value, bool):
            raise self.refuse(f"should be true or false, {self._is}")
        return self.value

    def number(self, *, positive: bool = False) -> float:
        """Return the value as a finite number.

        Raises:
            InvalidDescriptionError: It is none, or not positive where it is to be.
        """
        value = self.value
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(value) or (positive and value <= 0):
            kind = "a positive number" if positive else "a finite number"
            raise self.refuse(f"should be {kind}, {self._is}")
        return float(value)

    def numbers(self, *counts: int, positive: bool = False) -> tuple[float, ...]:
        """Return the value as a list of finite numbers, of one of the given lengths.

        Raises:
            InvalidDescriptionError: They are not as many, or no such numbers.
        """
        items = self.items() if isinstance(self.node, yaml.SequenceNode) else []
        if len(items) not in counts:
            wanted = " or ".join(map(str, counts))
            raise self.refuse(f"should be a list of {wanted} numbers, {self._is}")
        return tuple(item.number(positive=positive) for item in items)


def read_entries(path: Path, text: str) -> YamlEntry:
    """Parse a YAML document.

    Raises:
        InvalidDescriptionError: It is none.
    """
    with faults_of(path, InvalidDescriptionError):
        loader = RosLoader(text)
        node = loader.get_single_node()
        value = None if node is None else loader.construct_document(node)
    if node is None:
        raise InvalidDescriptionError(f"{path}: it is empty")
    return YamlEntry(path, "the world", node, value)


def _key(node: yaml.Node, mapping: Any) -> Any:
    """The key of a mapping that a node stands for: YAML may have made a number of it."""
    return next((key for key in mapping if str(key) == str(node.value)), node.value)
