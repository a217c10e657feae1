"""``launch.launch_introspector``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from .actions import EmitEvent, ExecuteProcess, LogInfo, RegisterEventHandler
from .event_handler import BaseEventHandler
from .launch_description import LaunchDescription
from .launch_description_entity import LaunchDescriptionEntity
from .some_substitutions_type import SomeSubstitutionsType
from .substitution import in_words
from .utilities import normalize_to_list_of_entities, normalize_to_list_of_substitutions


class LaunchIntrospector:
    """Formats a launch description as a tree of text."""

    def format_launch_description(self, launch_description: LaunchDescription) -> str:
        """Return the tree of a launch description."""
        return "\n".join([str(launch_description), *_tree(launch_description.entities)])


def _tree(entities: Iterable[LaunchDescriptionEntity]) -> Iterator[str]:
    listed = list(entities)
    for entity in listed:
        is_last = entity is listed[-1]
        line, *below = _lines(entity)
        yield ("└── " if is_last else "├── ") + line
        yield from (("    " if is_last else "│   ") + each for each in below)


def _lines(entity: LaunchDescriptionEntity) -> Iterator[str]:
    match entity:
        case LogInfo():
            yield f"LogInfo({in_words(entity.msg)})"
        case EmitEvent():
            yield f"EmitEvent(event='{entity.event.name}')"
        case ExecuteProcess():
            words = ", ".join(map(_text, entity.cmd))
            cwd = None if entity.cwd is None else f"'{_text(entity.cwd)}'"
            settings = f"cwd={cwd}, env={entity.env}, shell={entity.shell}"
            yield f"ExecuteProcess(cmd=[{words}], {settings})"
        case RegisterEventHandler():
            yield f"RegisterEventHandler('{entity.event_handler}'):"
            yield from _handler(entity.event_handler)
        case _:
            yield f"Action('{entity}')"


def _handler(handler: BaseEventHandler) -> Iterator[str]:
    when, entities = handler.describe()
    yield f"└── {when}"
    yield from (f"    {line}" for line in _tree(normalize_to_list_of_entities(entities)))


def _text(text: SomeSubstitutionsType) -> str:
    return in_words(normalize_to_list_of_substitutions(text))
