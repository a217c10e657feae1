"""``import teleopctl``: its names are those of a written list, typed, documented, and lazy."""

import ast
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import teleopctl

# What programs may rely on. Whoever changes it changes programs of others.
PUBLIC = [
    "Arm",
    "Bag",
    "BagMessage",
    "BagTopic",
    "BagWriter",
    "ControlStack",
    "ControllerInterface",
    "DecodedMessage",
    "ExecutionError",
    "Graph",
    "IkSolution",
    "InterfaceConfiguration",
    "InterfaceConfigurationType",
    "MotionResult",
    "MotionSettings",
    "Node",
    "PlanningError",
    "Robot",
    "RobotJoint",
    "RobotMesh",
    "RobotSimulation",
    "RunningArm",
    "TeleopctlError",
    "activate",
    "load_robot",
    "open_bag",
    "open_node",
    "read_bag",
    "read_raw_bag",
    "watch_graph",
]
API = Path(teleopctl.__file__).with_name("api")


def test_the_public_names_are_those_of_the_list():
    assert vars(teleopctl)["__all__"] == PUBLIC
    assert dir(teleopctl) == PUBLIC


def test_type_checkers_see_the_names_that_python_loads():
    tree = ast.parse(Path(teleopctl.__file__).read_text(encoding="utf-8"))
    (block,) = (statement for statement in tree.body if isinstance(statement, ast.If))
    typed = [
        alias.name
        for statement in block.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    ]
    assert sorted(typed) == PUBLIC


@pytest.mark.parametrize("name", PUBLIC)
def test_each_name_is_documented_here(name):
    value = getattr(teleopctl, name)
    assert inspect.getdoc(value)
    assert value.__module__.startswith("teleopctl.")


def test_importing_the_library_loads_nothing_heavy():
    code = "import sys, teleopctl; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=True
    )
    loaded = set(done.stdout.split())
    assert not loaded & {"numpy", "zenoh", "mujoco", "lxml", "yourdfpy", "trimesh", "yaml", "rich"}
    ours = sorted(name for name in loaded if name.startswith("teleopctl"))
    assert ours == ["teleopctl", "teleopctl.base", "teleopctl.base.lazy", "teleopctl.base.typed"]


def test_signatures_of_the_face_have_no_any():
    for file in API.glob("*.py"):
        names = {
            node.id for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Name)
        }
        assert "Any" not in names, file


# The class of a bag's message is made from the definition in the bag, which no type checker sees. A
# controller chooses the type of the state that it hands over to new code of its own.
WITH_ANY = {"ControllerInterface.import_state", "DecodedMessage"}


def signatures(name: str) -> Iterator[tuple[str, str]]:
    """Yield the signatures of a public name and of its public methods and properties."""
    value = getattr(teleopctl, name)
    members = {name: value}
    for base in inspect.getmro(value) if inspect.isclass(value) else ():
        if base.__module__.startswith("teleopctl."):
            members |= {f"{name}.{k}": v for k, v in vars(base).items() if not k.startswith("_")}
    for member, each in members.items():
        function = getattr(each, "fget", None) or getattr(each, "__func__", None) or each
        if callable(function):
            try:
                yield member, str(inspect.signature(function))
            except ValueError:
                continue


def test_no_further_signature_of_a_public_name_has_any():
    with_any = {
        member
        for name in PUBLIC
        for member, text in signatures(name)
        if re.search(r"\bAny\b", text)
    }
    assert with_any == WITH_ANY
