"""Modules that ``generate_parameter_library`` makes of YAML files, made here when imported.

Which modules a source package has is written in its ``setup.py`` (calls of
``generate_parameter_module``) or in its ``CMakeLists.txt`` (the command of that name); nothing is
run.
"""

from __future__ import annotations

import os
from importlib.machinery import ModuleSpec
from types import ModuleType

TYPE_CHECKING = False  # see `finder`
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_WORD = "generate_parameter_module"
_DEEPEST = 3
"""Folders above a Python package in which its ``package.xml`` is looked for."""


class ParameterModuleFinder:
    """Finder of ``<package>.<module>`` for source packages, after Python's own finders."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the import spec of a module that is made of a YAML file; or None."""
        if not path or fullname.count(".") != 1:
            return None
        folder = _source_folder(next(iter(path)))
        if folder is None:
            return None
        name = fullname.partition(".")[2]
        for module, yaml_file, validators in _declared(folder):
            if module == name:
                loader = _Loader(os.path.join(folder, yaml_file), validators)  # noqa: PTH118
                return ModuleSpec(fullname, loader)  # type: ignore[arg-type]  # by methods
        return None


class _Loader:
    def __init__(self, yaml_file: str, validators: str) -> None:
        self._yaml_file = yaml_file
        self._validators = validators

    def create_module(self, _spec: ModuleSpec) -> None:
        """Return None: the module is an ordinary one."""

    def exec_module(self, module: ModuleType) -> None:
        """Make the class of the file's parameters."""
        from generate_parameter_library_py.parameters import namespace_of

        name, made = namespace_of(self._yaml_file, self._validators)
        module.__file__ = self._yaml_file
        setattr(module, name, made)


def _source_folder(module_folder: str) -> str | None:
    """Return the folder with the ``package.xml`` of a Python package; None if there is none."""
    folder = module_folder
    for _ in range(_DEEPEST):
        folder = os.path.dirname(folder)  # noqa: PTH120 -- no pathlib in each Python process
        if os.path.isfile(os.path.join(folder, "package.xml")):  # noqa: PTH113, PTH118
            return folder
    return None


def _declared(folder: str) -> Iterator[tuple[str, str, str]]:
    """Yield module, YAML file and module of validators of each module that a package makes."""
    for name, read in (("setup.py", _of_setup), ("CMakeLists.txt", _of_cmake)):
        try:
            with open(os.path.join(folder, name), encoding="utf-8") as file:  # noqa: PTH118, PTH123
                text = file.read()
        except (OSError, UnicodeDecodeError):
            continue
        if _WORD in text:
            yield from read(text)


def _of_setup(text: str) -> Iterator[tuple[str, str, str]]:
    import ast

    try:
        tree = ast.parse(text)
    except SyntaxError:
        return
    known: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    known[target.id] = str(node.value.value)

    def word(value: ast.expr | None) -> str:
        if isinstance(value, ast.Constant):
            return str(value.value)
        return known.get(value.id, "") if isinstance(value, ast.Name) else ""

    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(_WORD):
            named = {keyword.arg: keyword.value for keyword in node.keywords}
            names = ("module_name", "yaml_file", "validation_module")
            given = [*node.args[:3], None, None, None]
            module, file, validators = (
                word(named.get(name, value)) for name, value in zip(names, given, strict=False)
            )
            if module and file:
                yield module, file, validators


def _of_cmake(text: str) -> Iterator[tuple[str, str, str]]:
    import re

    plain = re.sub("#.*", "", text)
    project = re.search(r"(?i)\bproject\s*\(\s*(\w+)", plain)
    for words in re.findall(rf"\b{_WORD}\s*\(([^)]*)\)", plain):
        given = words.replace("${PROJECT_NAME}", project[1] if project else "").split()
        if len(given) >= 2:
            yield given[0], given[1], given[2] if len(given) > 2 else ""
