"""``launch.frontend.parser``: parsers of XML and YAML launch files."""

from __future__ import annotations

import importlib
import os
import traceback
import warnings
from collections.abc import Collection, Iterable
from importlib import metadata
from pathlib import Path
from typing import Any, ClassVar, TextIO

from teleopctl.errors import TeleopctlError
from teleopctl.launch import load_launch_extensions, parse_text, read_step

from ..action import Action
from ..conditions import IfCondition, UnlessCondition
from ..invalid_launch_file_error import InvalidFrontendLaunchFileError
from ..launch_description import LaunchDescription
from ..substitution import Substitution
from ._methods import action_parse_methods, instantiate_action
from .entity import Entity
from .known import action_of, words_of
from .parse_substitution import (
    parse_if_substitutions,
    parse_substitution,
    replace_escaped_characters,
)

# Ours, which need no entry point.
_LANGUAGES = {"xml": "launch_xml", "yaml": "launch_yaml"}


class Parser:
    """Parser of an XML or YAML launch file to actions.

    A subclass for a language of its own has `load` and `get_file_extensions`.

    Attributes:
        language: Language that `load` reads: ``xml`` or ``yaml``; None for either.
    """

    language: ClassVar[str | None] = None
    frontend_parsers: ClassVar[dict[str, type[Parser]] | None] = None

    @classmethod
    def load_launch_extensions(cls) -> None:
        """Load the launch extensions of installed distributions, once."""
        load_launch_extensions()

    @classmethod
    def load_parser_implementations(cls) -> None:
        """Load the parsers of installed distributions, once."""
        if Parser.frontend_parsers is None:
            parsers = {
                name: importlib.import_module(module).Parser for name, module in _LANGUAGES.items()
            }
            for entry in metadata.entry_points(group="launch.frontend.parser"):
                try:
                    parsers[entry.name] = entry.load()
                except Exception:  # noqa: BLE001 -- a third-party parser may raise anything
                    warnings.warn(
                        f"Failed to load the parser extension: {entry.name}\n"
                        f"{traceback.format_exc()}",
                        stacklevel=2,
                    )
            Parser.frontend_parsers = dict(sorted(parsers.items()))

    @classmethod
    def _parsers(cls) -> dict[str, type[Parser]]:
        cls.load_parser_implementations()
        assert Parser.frontend_parsers is not None
        return Parser.frontend_parsers

    def parse_action(self, entity: Entity) -> Action:
        """Return the action of an element: a registered one, or one of ROS 2.

        Raises:
            ValueError: The element is invalid.
        """
        self.load_launch_extensions()
        if entity.type_name in action_parse_methods:
            return instantiate_action(entity, self)
        try:
            return action_of(read_step(entity.type_name, entity.element))
        except TeleopctlError as error:
            raise ValueError(f"`{entity.type_name}`: {error.message}") from error

    # Any: constructor arguments, which differ by class.
    def words_of(
        self, kind: type[Action], entity: Entity, ignore: Collection[str] = ()
    ) -> dict[str, Any]:
        """Return the constructor arguments of an action class of ROS 2, parsed from an element.

        Args:
            kind: The class, or one that derives from it.
            entity: Element of the launch file.
            ignore: Keys that are left alone.

        Raises:
            RuntimeError: The element has two conditions.
            TeleopctlError: The element is invalid.
        """
        self.load_launch_extensions()
        words, keys = words_of(kind, entity.element, ignore)
        entity.has_read(keys)
        holds = entity.get_attr("if", optional=True)
        fails = entity.get_attr("unless", optional=True)
        if holds is not None and fails is not None:
            raise RuntimeError("if and unless conditions can't be used simultaneously")
        if holds is not None:
            words["condition"] = IfCondition(self.parse_substitution(holds))
        if fails is not None:
            words["condition"] = UnlessCondition(self.parse_substitution(fails))
        return words

    def parse_description(self, entity: Entity) -> LaunchDescription:
        """Return the launch description in a file.

        Raises:
            RuntimeError: The file is not a launch file.
            ValueError: The element is invalid.
        """
        if entity.type_name != "launch":
            raise RuntimeError("Expected 'launch' as root tag")
        reason = entity.get_attr("deprecated", optional=True)
        actions = [self.parse_action(child) for child in entity.children]
        return LaunchDescription(actions, deprecated_reason=reason)

    def parse_substitution(self, value: str) -> list[Substitution]:
        """Return the substitutions in a text."""
        return parse_substitution(value)

    # Any: a value of whatever type stands in a launch file.
    def parse_if_substitutions(self, value: Any) -> Any:
        """Return a value with its texts parsed as substitutions, if they contain any."""
        return parse_if_substitutions(value)

    def escape_characters(self, value: str) -> str:
        """Return a text without escaping backslashes."""
        return replace_escaped_characters(value)

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """Return the file extensions that the parser reads."""
        return set()

    @classmethod
    def may_parse(cls, filename: str) -> bool:
        """Return whether the parser reads a file, by its extension."""
        return any(filename.endswith(f".{ending}") for ending in cls.get_file_extensions())

    @classmethod
    def get_available_extensions(cls) -> Iterable[str]:
        """Return the names of the parsers."""
        return cls._parsers().keys()

    @classmethod
    def is_filename_valid(cls, filename: str) -> bool:
        """Return whether any parser reads a file, by its extension."""
        return bool(cls.get_parsers_from_filename(filename))

    @classmethod
    def get_parsers_from_filename(cls, filename: str) -> list[type[Parser]]:
        """Return the parsers for a file, by its extension."""
        return [parser for parser in cls._parsers().values() if parser.may_parse(filename)]

    @classmethod
    def get_file_extensions_from_parsers(cls) -> set[str]:
        """Return the file extensions of all parsers."""
        return set().union(*(parser.get_file_extensions() for parser in cls._parsers().values()))

    @classmethod
    def load(cls, file: str | bytes | os.PathLike[str] | TextIO) -> tuple[Entity, Parser]:
        """Read a launch file; if its extension is unknown, try each parser.

        Returns:
            Root element of the file, and its parser.

        Raises:
            InvalidFrontendLaunchFileError: No parser can read the file.
        """
        if isinstance(file, str | bytes | os.PathLike):
            with Path(os.fsdecode(file)).open(encoding="utf-8") as opened:
                return cls.load(opened)
        name = getattr(file, "name", "")
        if cls.language is not None:
            return Entity(*parse_text(file.read(), Path(name or "<text>"), cls.language)), cls()
        named = cls.get_parsers_from_filename(name)
        errors: list[Exception] = []
        for parser in [*named, *(each for each in cls._parsers().values() if each not in named)]:
            try:
                return parser.load(file)
            except Exception as error:  # noqa: BLE001 -- a third-party parser may raise anything
                errors.append(error)
                file.seek(0)
        raise InvalidFrontendLaunchFileError(
            Path(name).suffix[1:] if named else "", likely_errors=errors
        )
