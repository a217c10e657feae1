"""What a stub says of a class is what the class does."""

import array
import ast
import itertools
from pathlib import Path

import numpy as np
import pytest

from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.message import Message
from teleopctl.interfaces.store import get_class, known_types
from teleopctl.interfaces.stubs import module_stub, write_stubs
from tests.samples import sample

TYPES = {
    "int": int,
    "float": float,
    "str": str,
    "bool": bool,
    "bytes": bytes,
    "list": list,
    "_array": array.array,
    "_NDArray": np.ndarray,
}

MODULES = {
    module: list(names)
    for module, names in itertools.groupby(
        known_types().built_in_names(), lambda name: name.rpartition("/")[0]
    )
}


def classes(nodes, path=()):
    """The classes of a stub that are messages, each with its dotted name."""
    for node in nodes:
        if isinstance(node, ast.ClassDef):
            here = (*path, node.name)
            if any(ast.unparse(base) == "_Message" for base in node.bases):
                yield ".".join(here), node
            yield from classes(node.body, here)


def made_class(module, dotted):
    top, *inner = dotted.split(".")
    found = get_class(f"{module}/{top}")
    for name in inner:
        found = getattr(found, name)
    return found


def attributes(node):
    """The fields of a class with the types that reading them gives, and its constants."""
    fields, constants = {}, {}
    for statement in node.body:
        if isinstance(statement, ast.AnnAssign):
            name = ast.unparse(statement.target)
            if statement.value is None:
                fields[name] = ast.unparse(statement.annotation)
            else:
                constants[name] = ast.literal_eval(statement.value)
        elif isinstance(statement, ast.FunctionDef) and statement.returns is not None:
            decorators = [ast.unparse(each) for each in statement.decorator_list]
            if decorators in (["property"], ["_builtins.property"]):
                fields[statement.name] = ast.unparse(statement.returns)
    return fields, constants


@pytest.mark.parametrize("module", sample(list(MODULES), 4))
def test_fields_constants_and_arguments_are_those_of_the_class(module):
    tree = ast.parse(module_stub(MODULES[module], known_types().find))
    found = dict(classes(tree.body))
    assert {dotted.partition(".")[0] for dotted in found} == {
        name.rpartition("/")[2] for name in MODULES[module]
    }
    for dotted, node in found.items():
        made = made_class(module, dotted)
        fields, constants = attributes(node)
        message = made()
        assert list(fields) == list(made.get_fields_and_field_types())
        for name, annotation in fields.items():
            kind = TYPES.get(annotation.partition("[")[0].removeprefix("_builtins."), Message)
            assert isinstance(getattr(message, name), kind), (dotted, name)
        for name, value in constants.items():
            assert getattr(made, name) == value
        assert list(constants) == [c.name for c in made.__definition__.constants]
        (init,) = [n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"]
        assert [argument.arg for argument in init.args.kwonlyargs] == list(fields)


def test_the_stub_of_a_message():
    text = "byte B=3\nfloat32 F=1.5\nstring S='a'\nstd_msgs/Header header\nfloat64[3] at\n"
    text += "uint8[<=4] data\nstring[] names\nint8 class\nOther other\n"
    known = Catalog("jazzy")
    known.add_text("my_msgs/msg/Mine", text)
    known.add_text("my_msgs/msg/Other", "")
    assert module_stub(["my_msgs/msg/Mine", "my_msgs/msg/Other"], known.find) == (
        "# Written by teleopctl from the definitions of the package.\n"
        "import numpy as _numpy\n"
        "from array import array as _array\n"
        "from collections.abc import Iterable as _Iterable\n"
        "from typing import Final as _Final\n"
        "from numpy.typing import NDArray as _NDArray\n"
        "from teleopctl.interfaces.message import Message as _Message\n"
        "from teleopctl.interfaces.protocols import Strings as _Strings\n"
        "import std_msgs.msg as _std_msgs_msg\n"
        "\n"
        "class Mine(_Message):\n"
        "    B: _Final = b'\\x03'\n"
        "    F: _Final = 1.5\n"
        "    S: _Final = 'a'\n"
        "    header: _std_msgs_msg.Header\n"
        "    @property\n"
        "    def at(self) -> _NDArray[_numpy.float64]: ...\n"
        "    @at.setter\n"
        "    def at(self, value: _Iterable[float]) -> None: ...\n"
        "    @property\n"
        "    def data(self) -> _array[int]: ...\n"
        "    @data.setter\n"
        "    def data(self, value: _Iterable[int]) -> None: ...\n"
        "    @property\n"
        "    def names(self) -> list[str]: ...\n"
        "    @names.setter\n"
        "    def names(self, value: _Strings) -> None: ...\n"
        "    class_: int\n"
        "    other: Other\n"
        "    def __init__(self, *, header: _std_msgs_msg.Header = ..., "
        "at: _Iterable[float] = ..., data: _Iterable[int] = ..., names: _Strings = ..., "
        "class_: int = ..., other: Other = ...) -> None: ...\n"
        "\n"
        "class Other(_Message):\n"
        "    def __init__(self) -> None: ...\n"
    )


def test_the_built_in_types_are_the_same_wherever_one_stands(tmp_path, monkeypatch):
    package = tmp_path / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>gadget_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text("string label\n")
    monkeypatch.chdir(tmp_path)
    known = Catalog("jazzy")
    assert known.user_names() == ["gadget_msgs/msg/Gadget"]
    assert not [name for name in known.built_in_names() if name.startswith("gadget_msgs")]
    assert set(known.names()) == {*known.user_names(), *known.built_in_names()}


def test_stubs_are_written_as_packages(tmp_path):
    written = write_stubs(
        tmp_path / "new",
        ["std_srvs/srv/Empty", "std_msgs/msg/Empty"],
        known_types().find,
        suffix="-x",
    )
    assert written == ["std_msgs", "std_srvs"]
    found = {path.relative_to(tmp_path) for path in tmp_path.rglob("*.pyi")}
    assert found == {
        Path("new", package, file)
        for package, file in [
            ("std_msgs-x", "__init__.pyi"),
            ("std_msgs-x", "msg.pyi"),
            ("std_srvs-x", "__init__.pyi"),
            ("std_srvs-x", "srv.pyi"),
        ]
    }
