"""``nav2_common.launch.rewritten_yaml``."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from launch import LaunchContext, SomeSubstitutionsType, Substitution
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions

from teleopctl.base import ros_yaml

# Ten times as fast, where it was built. Nav2's bringup rewrites a file of 500 lines 22 times.
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_PARAMETERS = "ros__parameters"


class RewrittenYaml(Substitution):
    """Path of a copy of a parameter file with replaced values and keys.

    Args:
        source_file: The file.
        param_rewrites: New values, by a key at any depth or by a whole path with dots; a whole path
            with ``ros__parameters`` in it is added where the file lacks it.
        root_key: What the whole file is put below, unless it is empty.
        key_rewrites: New names of keys.
        value_rewrites: New values by old ones.
        convert_types: Whether new values that look like numbers become numbers; truth values
            always do.
        out_dir: The folder for the copy.
    """

    def __init__(
        self,
        source_file: SomeSubstitutionsType,
        param_rewrites: Mapping[str, SomeSubstitutionsType],
        root_key: SomeSubstitutionsType | None = None,
        key_rewrites: Mapping[str, SomeSubstitutionsType] | None = None,
        value_rewrites: Mapping[str, SomeSubstitutionsType] | None = None,
        convert_types: bool = False,
        out_dir: SomeSubstitutionsType | None = None,
    ) -> None:
        super().__init__()
        self._source_file = normalize_to_list_of_substitutions(source_file)
        self._param_rewrites = dict(param_rewrites)
        self._key_rewrites = dict(key_rewrites or {})
        self._value_rewrites = dict(value_rewrites or {})
        self._root_key = root_key
        self._out_dir = out_dir
        self._convert_types = convert_types

    @property
    def name(self) -> list[Substitution]:
        """Path of the file."""
        return self._source_file

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"RewrittenYaml({', '.join(self._param_rewrites)})"

    def perform(self, context: LaunchContext) -> str:
        """Write the copy; return its path."""

        def text(given: SomeSubstitutionsType | None) -> str:
            return perform_substitutions(context, normalize_to_list_of_substitutions(given or ""))

        def texts(given: Mapping[str, SomeSubstitutionsType]) -> dict[str, str]:
            return {key: text(value) for key, value in given.items()}

        with Path(text(self._source_file)).open(encoding="utf-8") as file:
            data = ros_yaml.safe_load(file.read())
        values = {key: self._value(new) for key, new in texts(self._param_rewrites).items()}
        _set_everywhere(data, values)
        paths = set(_paths(data))
        for path, value in values.items():
            words = path.split(".")
            if path in paths or _PARAMETERS in words:
                _set(data, words, value)
        data = _renamed(data, texts(self._key_rewrites))
        replacements = {old: self._value(new) for old, new in texts(self._value_rewrites).items()}
        data = _replaced(data, replacements)
        if root_key := text(self._root_key):
            data = {root_key: data}
        folder = text(self._out_dir) or None
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", dir=folder, delete=False
        ) as rewritten:
            yaml.dump(data, rewritten, Dumper=_DUMPER)
        return rewritten.name

    def _value(self, text: str) -> bool | int | float | str:
        if self._convert_types:
            try:
                return float(text) if "." in text else int(text)
            except ValueError:
                pass
        return {"true": True, "false": False}.get(text.lower(), text)


# Any, here and below: what a YAML file holds.
def _set_everywhere(data: Any, values: Mapping[str, Any]) -> None:
    if isinstance(data, dict):
        for key, inner in data.items():
            _set_everywhere(inner, values)
            if key in values:
                data[key] = values[key]


def _paths(data: Any, path: str = "") -> list[str]:
    if isinstance(data, dict):
        items = data.items()
    elif isinstance(data, list):
        items = dict(enumerate(data)).items()
    else:
        return [path]
    start = f"{path}." if path else ""
    return [found for key, inner in items for found in _paths(inner, f"{start}{key}")]


def _set(data: Any, path: list[str], value: Any) -> None:
    for word in path[:-1]:
        data = data[int(word)] if isinstance(data, list) else data.setdefault(word, {})
    data[int(path[-1]) if isinstance(data, list) else path[-1]] = value


def _renamed(data: Any, names: Mapping[str, str]) -> Any:
    if not isinstance(data, dict):
        return data
    return {names.get(key, key): _renamed(inner, names) for key, inner in data.items()}


def _replaced(data: Any, values: Mapping[str, Any]) -> Any:
    if isinstance(data, dict):
        return {key: _replaced(inner, values) for key, inner in data.items()}
    if isinstance(data, list):
        return [_replaced(inner, values) for inner in data]
    return values.get(str(data), data)
