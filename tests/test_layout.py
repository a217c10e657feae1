"""The house rules: imports point down the floors and never in a circle, files fit in one head."""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "teleopctl"
# Past this a file is looked at again; it is split where it has two subjects, never by length.
LONGEST_FILE_LINES = 600
MOST_FILES_OF_A_FOLDER = 22

GROUND = {"base", "errors", "packages", "plugins"}

# What each folder may import beside the ground. A folder that is not listed may import nothing.
ALLOWED = {
    "interfaces": set(),
    "wire": {"interfaces"},
    "bag": {"interfaces", "node", "pictures", "wire"},
    "pictures": {"interfaces"},
    "diagram": {"wire"},
    "node": {"interfaces", "wire"},
    "robot": {"tf"},
    "tf": {"interfaces", "node"},
    "mujoco_model": {"robot", "tf"},
    "kinematics": {"mujoco_model", "robot", "tf"},
    "commander": {"interfaces", "kinematics", "node", "robot", "tf"},
    "control": {"interfaces", "node", "robot", "tf"},
    "launch": {"interfaces", "node", "robot", "wire"},
    "teleop": {"interfaces", "node", "tf"},
    "sim": {"interfaces", "mujoco_model", "node", "robot", "tf", "wire"},
    "compat": {"bag", "control", "interfaces", "launch", "node", "robot", "tf"},
    "viewer": {"diagram", "interfaces", "node", "pictures", "robot", "tf"},
    "nodes": {
        *("bag", "commander", "compat", "control", "diagram", "interfaces", "kinematics"),
        *("mujoco_model", "node", "pictures", "robot", "sim", "teleop", "tf", "viewer", "wire"),
    },
    "sweep": {"bag", "compat", "interfaces", "launch", "node"},
    "testing": {
        *("bag", "compat", "control", "interfaces", "launch", "mujoco_model", "node", "nodes"),
        *("robot", "sim", "tf", "wire"),
    },
    "cli": {
        *("bag", "commander", "compat", "control", "diagram", "interfaces", "kinematics"),
        *("launch", "node", "nodes", "robot", "sweep", "tf", "wire"),
    },
    "api": {
        *("bag", "control", "interfaces", "mujoco_model", "node", "robot", "sim", "tf", "wire"),
    },
    "lerobot": {"bag", "commander", "interfaces", "node", "pictures"},
    "__init__": {"api", "bag", "commander", "compat", "control", "kinematics", "node", "wire"},
    "__main__": {"cli"},
}

# The ground has an order of its own.
ALLOWED_ON_THE_GROUND = {
    "errors": set(),
    "base": {"errors"},
    "packages": {"base", "errors", "plugins"},
}


@cache
def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        found[name.removesuffix(".__init__")] = path
    return found


@cache
def outline(module: str) -> tuple[list[ast.Import | ast.ImportFrom], list[str]]:
    """Imports anywhere in a module, for type checkers too, and its public classes."""
    tree = ast.parse(modules()[module].read_text(encoding="utf-8"))
    imports = [one for one in statements(tree) if isinstance(one, (ast.Import, ast.ImportFrom))]
    classes = [one.name for one in tree.body if isinstance(one, ast.ClassDef)]
    return imports, [name for name in classes if not name.startswith("_")]


def import_statements(module: str) -> list[ast.Import | ast.ImportFrom]:
    """Those anywhere in a module, for type checkers too."""
    return outline(module)[0]


def statements(parent: ast.AST) -> Iterator[ast.stmt]:
    """All statements below a node; expressions, which are most of a tree, are passed over."""
    for child in ast.iter_child_nodes(parent):
        if isinstance(child, ast.stmt):
            yield child
        if isinstance(child, (ast.stmt, ast.ExceptHandler, ast.match_case)):
            yield from statements(child)


def source_of(statement: ast.ImportFrom, module: str) -> str | None:
    """The module of the package that a ``from`` names, with dots in front too; None for others."""
    name = statement.module or ""
    if statement.level:
        is_package = modules()[module].name == "__init__.py"
        above = module.split(".")
        kept = above[: len(above) - statement.level + is_package]
        name = ".".join([*kept, *([name] if name else [])])
    return name if name in modules() else None


def imported(module: str) -> Iterator[str]:
    """The modules of the package that one imports."""
    for statement in import_statements(module):
        if isinstance(statement, ast.Import):
            yield from (alias.name for alias in statement.names if alias.name in modules())
        elif source := source_of(statement, module):
            for alias in statement.names:
                inner = f"{source}.{alias.name}"
                yield inner if inner in modules() else source


def is_folder(module: str) -> bool:
    return modules()[module].name == "__init__.py" if module in modules() else True


def floor_of(module: str) -> str:
    return module.split(".")[1] if "." in module else "__init__"


def forbidden(module: str) -> set[str]:
    """The floors that a module imports and must not."""
    own = floor_of(module)
    if own in ALLOWED_ON_THE_GROUND:
        allowed = ALLOWED_ON_THE_GROUND[own]
    else:
        allowed = ALLOWED.get(own, set()) | GROUND
    return {floor_of(name) for name in imported(module)} - {own, "__init__"} - allowed


def test_imports_point_down_the_floors():
    assert {module: found for module in modules() if (found := forbidden(module))} == {}


def test_no_imports_run_in_a_circle():
    graph = {
        # A front door names what lies behind it; what lies behind it does not know the door.
        module: {
            name
            for name in imported(module)
            if name != module and not (path.name == "__init__.py" and name.startswith(module))
        }
        for module, path in modules().items()
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(reversed(error.args[1])))


def test_no_folders_import_each_other_in_a_circle():
    """Not even by way of different files: a folder that needs another one lies above it."""
    graphs: dict[str, dict[str, set[str]]] = {}
    for module, path in modules().items():
        if path.name == "__init__.py" or "compat.site" in module:
            continue
        for name in imported(module):
            own, other = module.split("."), name.split(".")
            pairs = enumerate(zip(own, other, strict=False))
            depth = next((number for number, (a, b) in pairs if a != b), 0)
            above = ".".join(own[:depth])
            folders = [f"{above}.{parts[depth]}" for parts in (own, other)]
            if depth > 1 and all(is_folder(each) for each in folders):
                graphs.setdefault(above, {}).setdefault(folders[0], set()).add(folders[1])
    assert "teleopctl.robot" in graphs
    for above, graph in graphs.items():
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            pytest.fail(f"{above}: {' -> '.join(reversed(error.args[1]))}")


def test_domains_know_nothing_of_each_other():
    domains = {"control", "launch", "sim", "viewer"}
    for domain in domains:
        assert not ALLOWED[domain] & domains


# ROS 2 itself gives these names to two classes, and programs of others use both.
ROS_2_NAMES_TWICE = {
    "Node": "rclpy and launch_ros",
    "LifecycleNode": "rclpy and launch_ros",
    "TimeoutException": "rclpy and tf2_ros",
}


def test_one_name_is_one_thing():
    """No public class has the name of another one, but for those that ROS 2 names so."""
    homes: dict[str, list[str]] = {}
    for module in modules():
        if "compat.site" not in module:
            for name in outline(module)[1]:
                homes.setdefault(name, []).append(module)
    twice = {name: found for name, found in homes.items() if len(found) > 1}
    assert twice.keys() == ROS_2_NAMES_TWICE.keys(), twice


def test_a_file_fits_in_one_head():
    lines = {
        name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in modules().items()
    }
    assert {name: count for name, count in lines.items() if count > LONGEST_FILE_LINES} == {}


def test_a_folder_has_about_a_dozen_files():
    # In compat/site every class has the module that it has in ROS 2; each noun has one in verbs.
    elsewhere = PACKAGE / "compat/site"
    folders = {path.parent for path in modules().values() if elsewhere not in path.parents}
    folders.remove(PACKAGE / "cli/verbs")
    for folder in folders:
        files = [path.name for path in folder.glob("*.py") if path.name != "__init__.py"]
        assert len(files) <= MOST_FILES_OF_A_FOLDER, folder
