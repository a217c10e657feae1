"""Names of interface types: as people write them, as they stand on the wire, as Python modules.

Light on purpose: the graph commands show type names without knowing any type.
"""

import re

from teleopctl.errors import InvalidTypeNameError

KINDS = ("msg", "srv", "action")

_DDS_MARK = "dds_::"
_PACKAGE = re.compile(r"[a-z][a-z0-9_]*\Z")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")


def to_dds(type_name: str) -> str:
    """Return the name of a type as rmw_zenoh writes it into keys and tokens.

    Args:
        type_name: ``package/kind/Name``.

    Returns:
        ``package::kind::dds_::Name_``.
    """
    *parents, name = type_name.split("/")
    return "::".join([*parents, "dds_", f"{name}_"])


def from_dds(text: str) -> str:
    """Return ``package/kind/Name`` for a name from the wire; any other shape stays as it is."""
    before, mark, name = text.rpartition(_DDS_MARK)
    if not mark or not before or not name.endswith("_"):
        return text
    return before.replace("::", "/") + name[:-1]


def normalize(type_name: str, kind: str = "msg") -> str:
    """Return the full name of a type.

    Args:
        type_name: ``package/Name`` or ``package/kind/Name``.
        kind: The kind meant when the name has none.

    Returns:
        ``package/kind/Name``.

    Raises:
        InvalidTypeNameError: The text is not the name of an interface type.
    """
    parts = type_name.split("/")
    if len(parts) == 2:
        parts.insert(1, kind)
    if (
        len(parts) != 3
        or parts[1] not in KINDS
        or not _PACKAGE.match(parts[0])
        or not _NAME.match(parts[2])
    ):
        raise InvalidTypeNameError(
            f"{type_name!r} is not the name of an interface type",
            hint="Write it as package/msg/Name, for example std_msgs/msg/String.",
        )
    return "/".join(parts)


def split(type_name: str) -> tuple[str, str, str]:
    """Return package, kind and name of a full type name."""
    package, kind, name = type_name.split("/")
    return package, kind, name


def module_name(type_name: str) -> str:
    """Return the Python module in which ROS 2's generator puts the class of a type.

    ``sensor_msgs/msg/CompressedImage`` lives in ``sensor_msgs.msg._compressed_image``; the parts
    of a service or an action live in the module of that service or action.
    """
    package, kind, name = split(type_name)
    if kind != "msg":
        name = name.split("_", 1)[0]
    return f"{package}.{kind}._{snake_case(name)}"


def snake_case(name: str) -> str:
    """Return a name in capitals and small letters as ROS 2's generators write it in small ones.

    ``GetParameters`` is ``get_parameters``; of ``RGBDImage`` it makes ``rgbd_image``.
    """
    spaced = re.sub(r"(.)([A-Z][a-z]+)", r"\1_\2", name)
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", spaced).lower()
