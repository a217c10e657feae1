"""Names of interface types: as written, on the wire, and as Python modules.

The module has few imports, since the graph commands show type names without loading any type.
"""

from __future__ import annotations

from teleopctl.errors import InvalidTypeNameError

KINDS = ("msg", "srv", "action")

_DDS_MARK = "dds_::"
# The import of re takes longer than all operations on names here.
_SMALL = frozenset("abcdefghijklmnopqrstuvwxyz")
_CAPITAL = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZ")
_SMALL_OR_DIGIT = _SMALL | frozenset("0123456789")
_OF_LOWER_NAMES = _SMALL_OR_DIGIT | {"_"}
_OF_NAMES = _OF_LOWER_NAMES | _CAPITAL


def to_dds(type_name: str) -> str:
    """Return a type name as in Zenoh keys and tokens, ``package::kind::dds_::Name_``.

    Args:
        type_name: Full name of the type, ``package/kind/Name``.
    """
    *parents, name = type_name.split("/")
    return "::".join([*parents, "dds_", f"{name}_"])


def from_dds(text: str) -> str:
    """Return ``package/kind/Name`` for a DDS type name; return other texts unchanged."""
    before, mark, name = text.rpartition(_DDS_MARK)
    if not mark or not before or not name.endswith("_"):
        return text
    return before.replace("::", "/") + name[:-1]


def normalize(type_name: str, kind: str = "msg") -> str:
    """Return the full name of a type, ``package/kind/Name``; a missing kind is filled in.

    Args:
        type_name: ``package/Name`` or ``package/kind/Name``.
        kind: Kind of the type if the name has none: ``msg``, ``srv`` or ``action``.

    Raises:
        InvalidTypeNameError: The text is not the name of an interface type.
    """
    parts = type_name.split("/")
    if len(parts) == 2:
        parts.insert(1, kind)
    if (
        len(parts) != 3
        or parts[1] not in KINDS
        or not is_lower_name(parts[0])
        or not _OF_NAMES.issuperset(parts[2])
        or parts[2][:1] not in _SMALL | _CAPITAL
    ):
        raise InvalidTypeNameError(
            f"{type_name!r} is not the name of an interface type",
            hint="Write it as package/msg/Name, for example std_msgs/msg/String.",
        )
    return "/".join(parts)


def is_lower_name(text: str) -> bool:
    """Return whether a text is a valid name of a package or a field."""
    return text[:1] in _SMALL and _OF_LOWER_NAMES.issuperset(text)


def split(type_name: str) -> tuple[str, str, str]:
    """Return package, kind and name of a full type name."""
    package, kind, name = type_name.split("/")
    return package, kind, name


def module_name(type_name: str) -> str:
    """Return the name of the Python module that has a type's class.

    The module of ``sensor_msgs/msg/CompressedImage`` is ``sensor_msgs.msg._compressed_image``; the
    parts of a service or an action are in the module of that service or action.
    """
    package, kind, name = split(type_name)
    if kind != "msg":
        name = name.split("_", 1)[0]
    return f"{package}.{kind}._{snake_case(name)}"


def snake_case(name: str) -> str:
    """Return a CamelCase name in snake_case, as ROS 2's generators convert it.

    ``GetParameters`` becomes ``get_parameters``, and ``RGBDImage`` becomes ``rgbd_image``.
    """
    words = name[:1]
    for before, letter, after in zip(name, name[1:], f"{name[2:]} ", strict=False):
        starts_word = after in _SMALL or before in _SMALL_OR_DIGIT
        words += f"_{letter}" if letter in _CAPITAL and starts_word else letter
    return words.lower()
