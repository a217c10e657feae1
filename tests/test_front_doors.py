"""Each room's front door, and the names that programs of others may rely on."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from tests.test_layout import PACKAGE, floor_of, import_statements, modules

ROOT = PACKAGE.parent
# Another name here is another import in programs of others. The rooms' other names are internal.
PUBLIC_NAMES = Path(__file__).with_name("public_names.txt").read_text(encoding="utf-8").split()
# The command line has no door but its entry point, and programs are run, not imported. The names of
# the plug-in for lerobot need lerobot.
ROOMS = sorted(
    name
    for path in PACKAGE.glob("*/__init__.py")
    if "__getattr__" in path.read_text(encoding="utf-8")
    and (name := path.parent.name) not in ("cli", "lerobot")
)
IMPORT = re.compile(r"^ *from (teleopctl(?:\.[a-z_]+)?) import (?:\(([^)]*)\)|(.+))$", re.MULTILINE)


def door(package: str) -> Path:
    return PACKAGE / package / "__init__.py"


@cache
def typed_names(package: str) -> dict[str, str]:
    """What type checkers see: each public name with the module that it comes from."""
    (block,) = (
        statement
        for statement in ast.parse(door(package).read_text(encoding="utf-8")).body
        if isinstance(statement, ast.If)
    )
    return {
        alias.asname or alias.name: str(statement.module)
        for statement in block.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }


def test_what_programs_may_rely_on_is_the_written_list():
    face = [f"teleopctl.{name}" for name in import_module("teleopctl").__dict__["__all__"]]
    testing = [f"teleopctl.testing.{name}" for name in typed_names("testing")]
    assert {*face, *testing} <= {*PUBLIC_NAMES}
    for public in PUBLIC_NAMES:
        module, _, name = public.rpartition(".")
        assert name in dir(import_module(module)), public


def test_the_documentation_imports_public_names_alone():
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.py")]
    used = set()
    for page in pages:
        for module, several, single in IMPORT.findall(page.read_text(encoding="utf-8")):
            names = re.findall(r"(?<! as )\b(?!as\b)\w+", several or single.partition("#")[0])
            used |= {f"{module}.{name}" for name in names}
    rooms = {f"teleopctl.{room}" for room in ROOMS} | {"teleopctl"}
    used = {name for name in used if name.rpartition(".")[0] in rooms} - rooms
    assert used <= {*PUBLIC_NAMES}
    assert "teleopctl.control.HardwareComponentInterface" in used


@pytest.mark.parametrize("package", ROOMS)
def test_type_checkers_see_the_names_that_python_loads(package):
    module = import_module(f"teleopctl.{package}")
    typed = typed_names(package)
    assert sorted(typed) == module.__all__
    for name, home in typed.items():
        assert getattr(module, name) is getattr(import_module(home), name)


@pytest.mark.parametrize("package", ROOMS)
def test_no_name_of_a_front_door_is_a_module_too(package):
    # Python would put the module in the name's place once somebody has imported it.
    files = {path.stem for path in door(package).parent.iterdir()}
    assert not files & typed_names(package).keys()


def test_what_is_not_public_is_no_attribute():
    from teleopctl import node

    with pytest.raises(AttributeError, match=r"'teleopctl\.node' has no attribute 'Nodee'"):
        node.Nodee  # type: ignore[attr-defined]  # noqa: B018


def reached_past_a_door(module: str) -> Iterator[str]:
    """What a module takes from another folder and its front door does not have."""
    for statement in import_statements(module):
        if not isinstance(statement, ast.ImportFrom) or not statement.module:
            continue
        _, _, place = statement.module.partition("teleopctl.")
        package, _, inner = place.partition(".")
        if package not in ROOMS or package == floor_of(module):
            continue
        for alias in statement.names:
            if inner or alias.name not in typed_names(package):
                yield f"{statement.module}.{alias.name}"


def test_nothing_outside_reaches_deeper():
    found = {module: list(reached_past_a_door(module)) for module in modules()}
    assert {module: names for module, names in found.items() if names} == {}
