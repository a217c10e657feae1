"""The definitions that come with teleopctl: their hashes, and where each is from."""

import re
from pathlib import Path
from typing import Any

import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

import teleopctl
from teleopctl.interfaces import hashing
from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.definition import Definition, FieldType, Shape

FOLDER = Path(teleopctl.__file__).parent / "interfaces" / "definitions"

# distribution, type and RIHS01 hash of every file; those of kilted where they are others
RECORDED = [
    line.split() for line in Path(__file__).with_name("hashes.txt").read_text().splitlines()
]


def names(folder: Path) -> list[str]:
    """The types that the files of a folder define."""
    files = folder.glob("[!_]*/*/*.*")
    return sorted(f"{f.parents[1].name}/{f.parent.name}/{f.stem}" for f in files)


def find(catalog: Catalog, name: str) -> Definition:
    found = catalog.find(name)
    assert found is not None, name
    return found


def type_hash(catalog: Catalog, name: str) -> str:
    return hashing.type_hash(find(catalog, name), lambda other: find(catalog, other))


def foreign_hash(foreign: Typestore, catalog: Catalog, name: str) -> str:
    """Return the hash that rosbags computes; to it a service is a message of its three parts.

    Args:
        foreign: Where types of the catalog are added that are not there yet.
        catalog: The definitions.
        name: Of the type.
    """
    pending = [name]
    while pending:
        definition = find(catalog, pending.pop())
        if definition.type_name in foreign.fielddefs:
            continue
        fields = [(field.attribute, described(field.type)) for field in definition.wire_fields]
        foreign.register({definition.type_name: ([], fields)})
        pending += definition.nested_types()
    return str(foreign.hash_rihs01(name))


def described(kind: FieldType) -> Any:  # Any: nested tuples, which rosbags has no public type for
    # rosbags takes a char for another type than ROS 2, to which it is a uint8
    base = "uint8" if kind.base == "char" else kind.base
    element = (
        (Nodetype.NAME, base) if kind.is_nested else (Nodetype.BASE, (base, kind.string_capacity))
    )
    match kind.shape:
        case Shape.SINGLE:
            return element
        case Shape.ARRAY:
            return (Nodetype.ARRAY, (element, kind.capacity))
    return (Nodetype.SEQUENCE, (element, kind.capacity))


def has_wide_string(catalog: Catalog, name: str) -> bool:
    definition = find(catalog, name)
    if any(field.type.base == "wstring" for field in definition.fields):
        return True
    return any(has_wide_string(catalog, nested) for nested in definition.nested_types())


@pytest.fixture(scope="module")
def catalogs() -> dict[str, Catalog]:
    return {name: Catalog(name, cached=False) for name in ("jazzy", "kilted", "lyrical")}


def test_every_definition_has_the_hash_that_is_recorded(catalogs):
    files = [("jazzy", name) for name in names(FOLDER)]
    for each in ("kilted", "lyrical"):
        files += [(each, name) for name in names(FOLDER / f"_{each}")]
    found = [[each, name, type_hash(catalogs[each], name)] for each, name in files]
    assert found == RECORDED


# All of them take three seconds, and they change only when definitions are added.
@pytest.mark.parametrize("step", [7, pytest.param(1, marks=pytest.mark.nightly)])
def test_the_recorded_hashes_are_those_of_another_implementation(catalogs, step):
    foreign = {distribution: get_typestore(Stores.EMPTY) for distribution in catalogs}
    for distribution, name, recorded in RECORDED[::step]:
        if has_wide_string(catalogs[distribution], name):
            continue  # rosbags has no wstring
        found = foreign_hash(foreign[distribution], catalogs[distribution], name)
        assert found == recorded, name


def test_the_origin_of_every_package_is_told():
    told = re.findall(
        r"^\| `([\w/]+)` \| [\w-]+/[\w-]+, `[\w./-]+` \| \d+\.\d+\.\d+ \| \w+",
        (FOLDER / "SOURCES.md").read_text(),
        re.MULTILINE,
    )
    packages = [folder.name for folder in FOLDER.glob("[!_]*/")]
    for each in ("_kilted", "_lyrical"):
        packages += [f"{each}/{folder.name}" for folder in FOLDER.glob(f"{each}/*/")]
    assert told == sorted(packages)
