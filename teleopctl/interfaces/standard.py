"""Messages of a ROS 2 distribution from rosbags' tables, without importing its type store.

The stores of rosbags create hundreds of classes when they are imported. Only their table of fields
and constants is needed, which is therefore cached in a file in the user's cache folder. The store
is imported if the file does not exist, or does not match the installed rosbags.
"""

from __future__ import annotations

import marshal
import os
import sys

from teleopctl.base.folders import cache_dir
from teleopctl.base.lazy import import_module
from teleopctl.base.typed import TYPE_CHECKING, Any, cache
from teleopctl.errors import UsageError
from teleopctl.interfaces.definition import (
    PLACEHOLDER,
    Constant,
    Definition,
    Field,
    FieldType,
    Shape,
)

if TYPE_CHECKING:
    from pathlib import Path

DEFAULT_DISTRIBUTION = "jazzy"
DISTRIBUTIONS = ("humble", "iron", "jazzy", "kilted", "lyrical")

_FORMAT = 3
_LONGEST_PLACE = 150  # file names may have 255 bytes
_BASE, _NAME, _ARRAY, _SEQUENCE = 1, 2, 3, 4  # rosbags.interfaces.Nodetype

# rosbags drops the default values of definitions. These are the defaults other than zero; a default
# that is the value of a constant applies to the distributions that have the constant.
_DEFAULTS: dict[tuple[str, str], object] = {("geometry_msgs/msg/Quaternion", "w"): 1.0}
_DEFAULT_CONSTANTS = {("sensor_msgs/msg/NavSatStatus", "status"): "STATUS_UNKNOWN"}

Table = dict[str, Any]


def distribution() -> str:
    """Return the ROS 2 distribution in ``ROS_DISTRO``: unset is jazzy, rolling the newest known.

    Raises:
        UsageError: The types of the distribution in ``ROS_DISTRO`` are not known.
    """
    name = os.environ.get("ROS_DISTRO") or DEFAULT_DISTRIBUTION
    if name == "rolling":
        return DISTRIBUTIONS[-1]
    if name not in DISTRIBUTIONS:
        raise UsageError(
            f"ROS_DISTRO is {name!r}, a distribution whose message types are not known",
            hint=f"Set it to one of {', '.join(DISTRIBUTIONS)}, rolling, or unset it.",
        )
    return name


def is_distribution_since(name: str) -> bool:
    """Return whether the ROS 2 distribution in use is the named one or a later one."""
    return DISTRIBUTIONS.index(distribution()) >= DISTRIBUTIONS.index(name)


class StandardTypes:
    """Message definitions of a ROS 2 distribution, from rosbags' table or a cached copy.

    Args:
        name: Name of the distribution.
        cached: Whether to use the user's cache folder.
    """

    def __init__(self, name: str, *, cached: bool = True) -> None:
        self._module = f"ros2_{name}"
        self._cached = cached
        self._table = _read_cache(self._module) if cached else None
        self._from_cache = self._table is not None
        if self._table is None:
            self._table = self._import()

    def names(self) -> list[str]:
        """Return the names of all message types in the distribution's table."""
        return list(self._rows())

    def find(self, type_name: str) -> Definition | None:
        """Return the `Definition` of a message type; None if the distribution lacks the type."""
        row = self._rows().get(type_name)
        if row is None:
            return None
        try:
            if self._from_cache:
                row = marshal.loads(row)  # noqa: S302 -- as the file, see _read_cache
            return parse_type_row(type_name, row)
        except (TypeError, ValueError, LookupError, EOFError):
            if not self._from_cache:
                raise
            self._table, self._from_cache = self._import(), False
            return self.find(type_name)

    def _rows(self) -> Table:
        assert self._table is not None
        return self._table

    def _import(self) -> Table:
        table: Table = import_module(f"rosbags.typesys.stores.{self._module}").FIELDDEFS
        if self._cached:
            _write_cache(self._module, table)
        return table


# Any: nested pairs and triples of rosbags' tables.
def parse_type_row(type_name: str, table_row: Any) -> Definition:
    """Return a type's `Definition` (fields, constants) from rosbags' table entry for that type.

    Raises:
        TypeError, ValueError or LookupError: The row has an unexpected structure.
    """
    raw_constants, raw_fields = table_row
    constants = tuple(Constant(str(name), str(base), value) for name, base, value in raw_constants)
    values = {constant.name: constant.value for constant in constants}
    fields = tuple(
        Field(
            name,
            _field_type(description),
            _DEFAULTS.get((type_name, name))
            or values.get(_DEFAULT_CONSTANTS.get((type_name, name), "")),
        )
        for name, description in raw_fields
    )
    if len(fields) == 1 and fields[0].name == PLACEHOLDER:
        fields = ()
    return Definition(type_name, fields, constants)


def _field_type(description: Any) -> FieldType:
    node, content = description
    if node == _BASE:
        base, bound = content
        return FieldType(str(base), string_capacity=int(bound))
    if node == _NAME:
        return FieldType(str(content))
    element = _field_type(content[0])
    capacity = int(content[1])
    if node == _ARRAY:
        shape = Shape.ARRAY
    elif node == _SEQUENCE:
        shape = Shape.BOUNDED if capacity else Shape.UNBOUNDED
    else:
        raise ValueError(f"unknown node type {node}")
    return FieldType(element.base, shape, capacity, element.string_capacity)


def cache_folder() -> Path:
    """Return the path of teleopctl's cache folder, which holds the type tables."""
    from pathlib import Path

    return Path(cache_dir())


# Paths are strings here: the import of pathlib takes longer than reading a table.


def _cache_file(module: str) -> str:
    # One file per environment; with a shared file, environments used in turn would overwrite it.
    site = os.path.abspath(os.path.join(_stores(), "..", "..", ".."))[-_LONGEST_PLACE:]
    place = "".join(c if c.isascii() and c.isalnum() else "-" for c in site)
    # Only this version of Python reads the file; importing json takes longer than reading it.
    name = f"{module}{place}.{_FORMAT}.{sys.implementation.cache_tag}"
    return os.path.join(cache_dir(), name)


@cache
def _stores() -> str:
    """Return the folder of rosbags' type tables."""
    # As importlib.util.find_spec, whose import takes longer than reading a table.
    spec = next(filter(None, (finder.find_spec("rosbags", None) for finder in sys.meta_path)))
    assert spec.submodule_search_locations is not None
    return os.path.join(spec.submodule_search_locations[0], "typesys", "stores")


def _fingerprint() -> list[list[Any]]:
    """Return values that change when another version of rosbags is installed.

    Reading the version of rosbags takes longer than reading the whole cache.
    """
    folder = _stores()
    with os.scandir(folder) as entries:
        stats = [(entry.name, entry.stat()) for entry in entries if entry.name.endswith(".py")]
    return [[folder], *sorted([name, s.st_size, s.st_mtime_ns] for name, s in stats)]


def _read_cache(module: str) -> Table | None:
    try:
        with open(_cache_file(module), "rb") as file:
            # Not load(), which reads the file byte by byte.
            content = marshal.loads(file.read())  # noqa: S302 -- private as Python's own bytecode
        if content["rosbags"] != _fingerprint():
            return None
        table = content["types"]
    except (OSError, ValueError, EOFError, LookupError, TypeError):
        return None
    return table if isinstance(table, dict) else None


def _write_cache(module: str, table: Table) -> None:
    """Write the cache file; if that fails, the next start imports the store again."""
    import json
    import tempfile
    from pathlib import Path

    path = Path(_cache_file(module))
    # Through JSON, which converts the enumerations of rosbags to plain numbers. Each row by itself,
    # since a command reads a few of hundreds.
    rows = {name: marshal.dumps(row) for name, row in json.loads(json.dumps(table)).items()}
    content = {"rosbags": _fingerprint(), "types": rows}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name)
        try:
            with os.fdopen(handle, "wb") as file:
                marshal.dump(content, file)
            Path(temporary).replace(path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError:
        return
