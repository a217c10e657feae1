"""Launch configurations, with the global parameters and remappings that ROS 2 stores there."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from typing import Any

from teleopctl.launch import (
    Evaluation,
    ParameterEntry,
    ParameterFileEntry,
    literal,
    parameter_value,
)

_PARAMETERS, _REMAPS = "global_params", "ros_remaps"


# Any: launch files may store any value.
class Configurations(MutableMapping[str, Any]):
    """Launch configurations by name, including the global parameters and remappings.

    Args:
        launch: The launch.
    """

    def __init__(self, launch: Evaluation) -> None:
        self._launch = launch

    # Any: launch files may store any value.
    def __getitem__(self, name: str) -> Any:
        scope = self._launch.scope
        if name == _REMAPS and scope.remaps:
            return list(scope.remaps)
        if name == _PARAMETERS and scope.parameters:
            return [self._parameter(entry) for entry in scope.parameters]
        return scope.variables[name]

    # Any: launch files may store any value.
    def __setitem__(self, name: str, value: Any) -> None:
        scope = self._launch.scope
        if name == _REMAPS:
            scope.remaps = tuple((source, target) for source, target in value)
        elif name == _PARAMETERS:
            scope.parameters = tuple(map(_given, value))
        else:
            scope.variables[name] = value

    def __delitem__(self, name: str) -> None:
        scope = self._launch.scope
        self[name]
        if name == _REMAPS:
            scope.remaps = ()
        elif name == _PARAMETERS:
            scope.parameters = ()
        else:
            del scope.variables[name]

    def __iter__(self) -> Iterator[str]:
        yield from self._launch.scope.variables
        yield from (name for name in (_REMAPS, _PARAMETERS) if name in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return repr(dict(self))

    # Any: launch files may store any value.
    def copy(self) -> dict[str, Any]:
        """Return a copy of the current values."""
        return dict(self)

    # Any: launch files may store any value.
    def _parameter(self, entry: ParameterEntry | ParameterFileEntry) -> Any:
        if isinstance(entry, ParameterFileEntry):
            return self._launch.text(entry.path)
        value = parameter_value(entry, self._launch.context)
        return self._launch.text(entry.name), tuple(value) if isinstance(value, list) else value


# Any: a path, or a name and a value.
def _given(entry: Any) -> ParameterEntry | ParameterFileEntry:
    if isinstance(entry, str):
        return ParameterFileEntry(literal(entry))
    name, value = entry
    return ParameterEntry(literal(name), list(value) if isinstance(value, tuple) else value, None)
