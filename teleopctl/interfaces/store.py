"""Message, service and action types of this process, by name.

Classes are made on first use, and the class of a name never changes. The functions are safe to call
from any thread.
"""

from __future__ import annotations

import os
from _thread import RLock  # importing threading would double the import time

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, ClassVar, Mapping, cache
from teleopctl.errors import InvalidMessageError, InvalidTypeNameError
from teleopctl.interfaces import hashing
from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.definition import Definition
from teleopctl.interfaces.standard import cache_folder
from teleopctl.interfaces.typenames import module_name, normalize, split

if TYPE_CHECKING:
    from pathlib import Path

    from type_description_interfaces.msg import TypeDescription

    from teleopctl.interfaces.message import Message

_CANCEL_GOAL = "action_msgs/srv/CancelGoal"
_GOAL_STATUS = "action_msgs/msg/GoalStatusArray"
_WITHOUT_HASHES = frozenset({"humble"})

_lock = RLock()
_classes: dict[str, type[Any]] = {}


class ServiceBase:
    """Base of service classes, which hold the classes ``Request``, ``Response`` and ``Event``."""

    TYPE_NAME: ClassVar[str]
    Request: ClassVar[type[Message]]
    Response: ClassVar[type[Message]]
    Event: ClassVar[type[Message]]

    def __init__(self) -> None:
        raise NotImplementedError("A service has no instances; make a Request or a Response.")


class ActionBase:
    """Base of action classes, which hold ``Goal``, ``Result``, ``Feedback`` and ``Impl``.

    ``Impl`` has the types of an action on the wire: ``SendGoalService``, ``GetResultService``,
    ``FeedbackMessage``, ``CancelGoalService`` and ``GoalStatusMessage``.
    """

    TYPE_NAME: ClassVar[str]
    Goal: ClassVar[type[Message]]
    Result: ClassVar[type[Message]]
    Feedback: ClassVar[type[Message]]
    Impl: ClassVar[Any]  # Any: each action has its own class

    def __init__(self) -> None:
        raise NotImplementedError("An action has no instances; make a Goal.")


# Any, here and below: the class depends on the name. Programs with fixed types import the classes
# (`from std_msgs.msg import String`), for which type checkers have stubs.


def get_message(type_name: str) -> type[Any]:
    """Return the class of a message type by name; made on first use.

    Args:
        type_name: ``package/msg/Name``, ``package/Name``, or the name of a part of a service or an
            action such as ``package/srv/Name_Request``.

    Raises:
        InvalidTypeNameError: The name is malformed, or that of a service or action.
        InvalidMessageError: The type does not exist.
    """
    found = _classes.get(type_name)
    if found is not None and not issubclass(found, (ServiceBase, ActionBase)):
        return found
    name = normalize(type_name)
    definition = _definition(name)
    if _is_service(name) or _is_action(name):
        what = "a service" if _is_service(name) else "an action"
        raise InvalidTypeNameError(f"{name} is {what}, not a message")
    with _lock:
        if name not in _classes:
            # Commands that only print definitions make no classes.
            import copyreg

            from teleopctl.interfaces.message import make_class

            made = make_class(definition, get_message)
            # Classes made here cannot be imported: pickle finds them by type name.
            copyreg.pickle(made, _reduce)
            _classes[name] = made
        return _classes[name]


def restore(type_name: str, values: Mapping[str, object]) -> Message:
    """Return a message made from type name and field values; called by pickle and copy."""
    message: Message = get_message(type_name)(**values)
    return message


def _reduce(message: Message) -> tuple[Callable[..., Message], tuple[str, dict[str, Any]]]:
    fields = message.__definition__.fields
    values = {field.attribute: getattr(message, field.attribute) for field in fields}
    return restore, (message.TYPE_NAME, values)


def get_service(type_name: str) -> type[Any]:
    """Return the class of a service with its ``Request``, ``Response`` and ``Event``.

    Args:
        type_name: ``package/srv/Name``, ``package/Name``, or one of the services of an action such
            as ``package/action/Name_SendGoal``.

    Raises:
        InvalidTypeNameError: The name is malformed, or not that of a service.
        InvalidMessageError: The type does not exist.
    """
    name = normalize(type_name, "srv")
    if not _is_service(name):
        _definition(name)
        raise InvalidTypeNameError(f"{name} is not a service")
    with _lock:
        if name not in _classes:
            _definition(name)
            parts = {
                part: get_message(f"{name}_{part}") for part in ("Request", "Response", "Event")
            }
            _classes[name] = type(split(name)[2], (ServiceBase,), _namespace(name) | parts)
        return _classes[name]


def get_action(type_name: str) -> type[Any]:
    """Return the class of an action with its ``Goal``, ``Result``, ``Feedback`` and ``Impl``.

    Args:
        type_name: ``package/action/Name`` or ``package/Name``.

    Raises:
        InvalidTypeNameError: The name is malformed, or not that of an action.
        InvalidMessageError: The type does not exist.
    """
    name = normalize(type_name, "action")
    if not _is_action(name):
        _definition(name)
        raise InvalidTypeNameError(f"{name} is not an action")
    with _lock:
        if name not in _classes:
            _definition(name)
            parts = {part: get_message(f"{name}_{part}") for part in ("Goal", "Result", "Feedback")}
            from types import SimpleNamespace

            implementation = SimpleNamespace(
                SendGoalService=get_service(f"{name}_SendGoal"),
                GetResultService=get_service(f"{name}_GetResult"),
                FeedbackMessage=get_message(f"{name}_FeedbackMessage"),
                CancelGoalService=get_service(_CANCEL_GOAL),
                GoalStatusMessage=get_message(_GOAL_STATUS),
            )
            namespace = _namespace(name) | parts | {"Impl": implementation}
            _classes[name] = type(split(name)[2], (ActionBase,), namespace)
        return _classes[name]


def get_class(type_name: str) -> type[Any]:
    """Return the class of a message, service or action type.

    Raises:
        TeleopctlError: The type does not exist.
    """
    name = normalize(type_name)
    if _is_action(name):
        return get_action(name)
    return get_service(name) if _is_service(name) else get_message(name)


@cache
def type_hash(type_name: str) -> str:
    """Return the hash of a type, ``RIHS01_…``; in Humble ``TypeHashNotSupported``.

    Args:
        type_name: Full name of a message, a service, an action or a type derived from them.

    Returns:
        The hash, or ``TypeHashNotSupported`` in Humble, which has no hashes.

    Raises:
        TeleopctlError: The type, or a type that it uses, is not known.
    """
    definition = _definition(normalize(type_name))
    if known_types().distribution in _WITHOUT_HASHES:
        return hashing.NOT_SUPPORTED
    return hashing.type_hash(definition, _definition)


def type_description(type_name: str) -> dict[str, Any]:  # Any: JSON's values
    """Return the description of a type and of all types used, as dictionaries.

    Raises:
        TeleopctlError: The type, or a type that it uses, is not known.
    """
    return hashing.type_description(_definition(normalize(type_name)), _definition)


def list_types(kind: str | None = None) -> list[str]:
    """Return the sorted names of all known types, optionally of one kind."""
    return known_types().names(kind)


def definition_text(type_name: str) -> str:
    """Return the definition text of a type, without the texts of nested types.

    Raises:
        TeleopctlError: The type does not exist.
    """
    return _definition(normalize(type_name)).render()


def definition_file(type_name: str) -> Path:
    """Return the path of a file with a type's definition; write one to the cache if needed.

    A type from rosbags' tables, or from another node's description, has no file: its definition is
    written into the user's cache folder.

    Raises:
        TeleopctlError: The type does not exist.
    """
    name = normalize(type_name)
    text = definition_text(name)
    file = known_types().file(name)
    if file is None:
        package, kind, stem = split(name)
        file = cache_folder() / "definitions" / package / kind / f"{stem}.{kind}"
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.parent.mkdir(parents=True, exist_ok=True)
            part = file.with_name(f"{file.name}.{os.getpid()}")
            part.write_text(text, encoding="utf-8")
            part.replace(file)
    return file


def complete_definition_text(type_name: str) -> str:
    """Return the definition text of a message with those of all nested types.

    The parts are separated as in ROS bags: a line of 80 equals signs, then ``MSG: package/Name``.

    Raises:
        TeleopctlError: The type, or a type that it uses, is not known.
    """
    return _complete_text(normalize(type_name), _definition)


def described_definition_text(description: TypeDescription, type_name: str | None = None) -> str:
    """Return the complete definition text of a type from another node's description.

    The known types of this process are neither used nor changed.

    Args:
        description: Type description received from another node; not trusted.
        type_name: Full name of a type in the description; by default the described type.

    Raises:
        TeleopctlError: The description is invalid, or lacks a type.
    """
    from teleopctl.interfaces.foreign.description import definitions

    described = {definition.type_name: definition for definition in definitions(description)}

    def lookup(name: str) -> Definition:
        if name not in described:
            raise InvalidMessageError(f"The description lacks the type {name}")
        return described[name]

    return _complete_text(type_name or next(iter(described)), lookup)


def _complete_text(type_name: str, lookup: Callable[[str], Definition]) -> str:
    names = [type_name]
    for name in names:  # grows while it is read
        names.extend(n for n in lookup(name).nested_types() if n not in names)
    head, *others = names
    parts = [lookup(head).render()]
    parts.extend(f"MSG: {n.replace('/msg/', '/')}\n{lookup(n).render()}" for n in others)
    return f"{'=' * 80}\n".join(parts)


def add_definitions(folder: str | Path, package_name: str) -> list[str]:
    """Add the types in a package's ``msg``, ``srv``, ``action`` folders; return their names.

    Args:
        folder: Folder that contains ``msg``, ``srv`` or ``action``.
        package_name: Name of the package.

    Returns:
        Full names of the added types.

    Raises:
        TeleopctlError: The folder has no definition, a definition cannot be parsed, or a type is
            already in use with another definition.
    """
    added = known_types().add_folder(folder, package_name)
    type_hash.cache_clear()
    return added


def add_definition_text(type_name: str, text: str) -> None:
    """Add a type, with its derived types, to this process's types by its definition text.

    Raises:
        TeleopctlError: The text cannot be parsed, or the type is already in use with another
            definition.
    """
    known_types().add_text(normalize(type_name), text)
    type_hash.cache_clear()


def add_description(description: TypeDescription) -> None:
    """Add another node's type to the known types; raise if it contradicts a known one.

    Known types are not replaced; their fields must equal those of the description.

    Args:
        description: Type description received from another node; not trusted.

    Raises:
        InvalidMessageError: The description is invalid, or contradicts a known type.
    """
    from teleopctl.interfaces.foreign.description import definitions

    described = definitions(description)
    for definition in described:
        known = known_types().find(definition.type_name)
        if known is not None and hashing.fields_of(known) != hashing.fields_of(definition):
            raise InvalidMessageError(
                f"{definition.type_name} is defined here differently than where it is used",
                hint="The packages that define it have different versions.",
            )
    known_types().add(d for d in described if known_types().find(d.type_name) is None)


def known_types() -> Catalog:
    """Return the `Catalog` of this process, which holds all known type definitions."""
    with _lock:
        return _make_catalog()


@cache
def _make_catalog() -> Catalog:
    return Catalog()


def _definition(name: str) -> Definition:
    found = known_types().find(name)
    if found is None:
        unknown = InvalidMessageError(f"Unknown interface type {name}", hint=_similar(name))
        place = known_types().place_of_use(name)
        raise unknown if place is None else unknown.at(place)
    return found


def _similar(name: str) -> str:
    from teleopctl.errors import similar_names

    known = list_types()
    last = split(name)[2].lower()
    close = [other for other in known if split(other)[2].lower() == last]
    close = close or similar_names(name, known, least=0.8)
    near = f"Did you mean {' or '.join(close[:3])}? " if close else ""
    if near and any(split(other)[0] == split(name)[0] for other in known):
        return near.rstrip()
    return (
        f"{near}Put the folder of the package that defines it, with its package.xml, on "
        "TELEOPCTL_PACKAGE_PATH."
    )


def _is_service(name: str) -> bool:
    kind, short = split(name)[1:]
    if kind == "srv":
        return "_" not in short
    return kind == "action" and short.endswith(("_SendGoal", "_GetResult"))


def _is_action(name: str) -> bool:
    kind, short = split(name)[1:]
    return kind == "action" and "_" not in short


def _namespace(name: str) -> dict[str, Any]:
    return {"TYPE_NAME": name, "__module__": module_name(name), "__doc__": f"{name}."}
