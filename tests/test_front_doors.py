"""Each folder's front door: its names are those of a written list, and nobody goes round it."""

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from tests.test_layout import PACKAGE, floor_of, import_statements, modules

LISTED = Path(__file__).with_name("public_names.txt").read_text(encoding="utf-8").split()

# Whoever changes a name in the list changes what programs of others import.
PUBLIC_NAMES: dict[str, list[str]] = {}
for line in LISTED:
    _, folder, public = line.split(".")
    PUBLIC_NAMES.setdefault(folder, []).append(public)


def door(package: str) -> Path:
    return PACKAGE / package / "__init__.py"


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


@pytest.mark.parametrize("package", PUBLIC_NAMES)
def test_a_front_door_has_the_names_of_the_written_list(package):
    assert import_module(f"teleopctl.{package}").__all__ == sorted(PUBLIC_NAMES[package])


@pytest.mark.parametrize("package", PUBLIC_NAMES)
def test_type_checkers_see_the_names_that_python_loads(package):
    module = import_module(f"teleopctl.{package}")
    typed = typed_names(package)
    assert sorted(typed) == module.__all__
    for name, home in typed.items():
        assert getattr(module, name) is getattr(import_module(home), name)


@pytest.mark.parametrize("package", PUBLIC_NAMES)
def test_no_public_name_is_a_module_too(package):
    # Python would put the module in the name's place once somebody has imported it.
    files = {path.stem for path in door(package).parent.iterdir()}
    assert not files & set(PUBLIC_NAMES[package])


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
        if package not in PUBLIC_NAMES or package == floor_of(module):
            continue
        for alias in statement.names:
            if inner or alias.name not in PUBLIC_NAMES[package]:
                yield f"{statement.module}.{alias.name}"


def test_nothing_outside_reaches_deeper():
    found = {module: list(reached_past_a_door(module)) for module in modules()}
    assert {module: names for module, names in found.items() if names} == {}
