"""Files and programs that a ``CMakeLists.txt`` installs, found without running CMake.

ROS 2's packages of descriptions, launch files and scripts install whole folders and lists of files:
``install(DIRECTORY description/urdf bringup/launch DESTINATION share/${PROJECT_NAME})``,
``install(PROGRAMS ${scripts} DESTINATION lib/${PROJECT_NAME})``. These calls are evaluated with the
project's name, variables of ``set``, ``list(APPEND …)`` and ``file(GLOB …)``, ``foreach`` and
``add_subdirectory``. Each branch of an ``if`` is taken; words with other variables are left out.
Patterns that exclude files are ignored: an additional file does no harm.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path

from teleopctl.base.typed import Final, NamedTuple

_COMMENT: Final = re.compile(r"#[^\n]*")
_CALL: Final = re.compile(r"\b(\w+)\s*\(([^()]*)\)")
_WORD: Final = re.compile(r'"([^"]*)"|([^\s"]+)')
_VARIABLE: Final = re.compile(r"\$\{(\w+)\}")
_TOP: Final = "/source"  # stands for the folder of the first script
_TOP_FOLDERS: Final = ("CMAKE_SOURCE_DIR", "PROJECT_SOURCE_DIR")
_CURRENT_FOLDERS: Final = ("CMAKE_CURRENT_LIST_DIR", "CMAKE_CURRENT_SOURCE_DIR")
_MOST_FILES: Final = 10_000  # a description with 2,000 meshes is a large one
_MOST_CALLS: Final = 10_000  # of all rounds of loops together

# Keywords that end the list of sources in a call.
_OPTIONS: Final = re.compile(
    "COMPONENT|CONFIGURATIONS|DESTINATION|(DIRECTORY_|FILE_)?PERMISSIONS|EXCLUDE_FROM_ALL"
    "|EXPORT|FILES_MATCHING|MESSAGE_NEVER|OPTIONAL|PATTERN|REGEX|RENAME|TYPE"
    "|USE_SOURCE_PERMISSIONS|(ARCHIVE|LIBRARY|RUNTIME|INCLUDES)"
)


class Installation(NamedTuple):
    """Files and programs that a CMake script installs.

    Attributes:
        files: Pairs of a path below the install prefix, such as ``share/arm/launch/up.yaml``, and
            the file's path relative to the script's folder.
        programs: Installed paths that are programs regardless of the file's permissions.
        modules: Folders of Python packages, relative to the script's folder, by package name.
        targets: Names of CMake targets that are compiled and installed as programs.
        hooks: Paths of environment hooks, relative to the script's folder.
    """

    files: list[tuple[str, str]]
    programs: set[str]
    modules: dict[str, str]
    targets: set[str]
    hooks: list[str]


def installation(text: str, folder: Path) -> Installation:
    """Return the files and programs that a CMake script would install, without running CMake.

    Args:
        text: Text of the script.
        folder: Folder of the script.
    """
    script = _Script(folder)
    with suppress(RecursionError):  # a thousand nested loops
        script.run(text, ".")
    return script.installed


class _Script:
    def __init__(self, folder: Path) -> None:
        self.installed = Installation([], set(), {}, set(), [])
        self._folder = folder
        self._values: dict[str, list[str]] = {key: [_TOP] for key in _TOP_FOLDERS}
        self._values["CMAKE_INSTALL_DATADIR"] = ["share"]
        self._folders_read = {"."}
        self._calls_left = _MOST_CALLS
        self._files_left = _MOST_FILES

    def run(self, text: str, below: str) -> None:
        """Evaluate the calls of a CMake script in a subfolder; add the files that they install."""
        outside = self._values
        self._values = outside | {key: [posixpath.join(_TOP, below)] for key in _CURRENT_FOLDERS}
        calls = [(call[1].lower(), call[2]) for call in _CALL.finditer(_COMMENT.sub("", text))]
        self._run(calls, below)
        self._values = outside

    def _run(self, calls: list[tuple[str, str]], below: str) -> None:
        at = 0
        while at < len(calls) and self._calls_left:
            self._calls_left -= 1
            name, text = calls[at]
            at += 1
            if name != "foreach":
                self._call(name, list(self._words(text)), below)
                continue
            end = _end_of_loop(calls, at)
            variable, *items = [*self._words(text), ""]
            for item in items[:-1]:
                if item not in ("IN", "ITEMS", "LISTS"):
                    known = self._values.get(item) if "LISTS" in items else None
                    for value in known or [item]:
                        self._values[variable] = [value]
                        self._run(calls[at:end], below)
            at = end

    def _call(self, name: str, words: list[str], below: str) -> None:
        match name, words:
            case "project", [project, *_]:
                self._values["PROJECT_NAME"] = self._values["CMAKE_PROJECT_NAME"] = [project]
            case "set", [variable, *value]:
                self._values[variable] = value
            case "list", ["APPEND", variable, *value]:
                self._values[variable] = self._values.get(variable, []) + value
            case "file", [("GLOB" | "GLOB_RECURSE") as kind, variable, *patterns]:
                self._values[variable] = self._globbed(patterns, below, kind == "GLOB_RECURSE")
            case "add_subdirectory", [inner, *_]:
                inner = _place(below, inner)
                if inner not in self._folders_read:
                    self._folders_read.add(inner)
                    self.run(_text_of(self._folder / inner / "CMakeLists.txt"), inner)
            case "rclcpp_components_register_node", [_, *rest]:
                if program := _value_after("EXECUTABLE", rest):
                    self.installed.targets.add(program)
            case "install", ["TARGETS", *rest]:
                self._install_targets(rest)
            case "install", [("DIRECTORY" | "FILES" | "PROGRAMS") as kind, *rest]:
                self._install(kind, rest, below)
            case "catkin_install_python", ["PROGRAMS", *rest]:
                self._install("PROGRAMS", rest, below)
            case "rosidl_generate_interfaces", [_, *words]:
                self._install_interfaces(words, below)
            case "ament_environment_hooks", hooks:
                self.installed.hooks.extend(_place(below, hook) for hook in hooks)
            case "ament_python_install_package", [module, *rest]:
                place = _value_after("PACKAGE_DIR", rest) or module
                self.installed.modules[module] = _place(below, place)

    def _words(self, text: str) -> Iterator[str]:
        """Yield the words of a call with variables replaced; skip words with unknown variables."""
        for quoted, bare in _WORD.findall(text):
            whole = _VARIABLE.fullmatch(bare)
            if whole:
                yield from self._values.get(whole[1], ())
            elif all(variable in self._values for variable in _VARIABLE.findall(quoted or bare)):
                yield _VARIABLE.sub(lambda one: ";".join(self._values[one[1]]), quoted or bare)

    def _globbed(self, patterns: list[str], below: str, recursive: bool) -> list[str]:
        relative_to = None
        while len(patterns) > 1 and patterns[0] in ("LIST_DIRECTORIES", "RELATIVE"):
            if patterns[0] == "RELATIVE":
                relative_to = _place(below, patterns[1])
            patterns = patterns[2:]
        found: list[str] = []
        for pattern in patterns:
            if pattern == "CONFIGURE_DEPENDS":
                continue
            start, _, last = _place(below, pattern).rpartition("/")
            wanted = "/".join(part for part in (start, "**" if recursive else "", last) if part)
            try:
                files = sorted(islice(self._folder.glob(wanted), _MOST_FILES))
            except (ValueError, NotImplementedError, IndexError):  # not a pattern for pathlib
                continue
            for file in files:
                path = Path(os.path.relpath(file, self._folder)).as_posix()
                found.append(
                    posixpath.relpath(path, relative_to)
                    if relative_to is not None
                    else posixpath.join(_TOP, path)
                )
        return found

    def _install_targets(self, words: list[str]) -> None:
        sources, options = _split(words)
        for at, word in enumerate(options[:-1]):
            folder = options[at + 1]
            if word == "DESTINATION" and folder.startswith(("lib/", "libexec/")):
                self.installed.targets.update(sources)

    def _install(self, kind: str, words: list[str], below: str) -> None:
        sources, options = _split(words)
        target = _value_after("DESTINATION", options)
        if target is None:
            return
        renamed = _value_after("RENAME", options)
        for source in sources:
            path = _place(below, source)
            if kind == "DIRECTORY":
                # As with rsync: `urdf` is installed as a folder of that name, `urdf/` as the
                # content of the folder.
                inside = source.endswith("/")
                name = "" if inside else posixpath.basename(path)
                self._install_folder(path, posixpath.join(target, name))
                continue
            name = renamed or posixpath.basename(path)
            installed = posixpath.normpath(posixpath.join(target, name))
            self.installed.files.append((installed, path))
            if kind == "PROGRAMS" or "OWNER_EXECUTE" in options:
                self.installed.programs.add(installed)

    def _install_interfaces(self, words: list[str], below: str) -> None:
        """Add the definition files of interfaces, which are installed by their kind."""
        for word in words:
            # A colon is between a base folder and a path below it.
            file = _place(below, word.replace(":", "/"))
            name = posixpath.basename(file)
            kind = name.rpartition(".")[2]
            if kind == "idl":
                kind = posixpath.basename(posixpath.dirname(file))
            if kind in ("msg", "srv", "action"):
                target = f"share/{self._values.get('PROJECT_NAME', [''])[0]}/{kind}/{name}"
                self.installed.files.append((target, file))

    def _install_folder(self, source: str, target: str) -> None:
        top = self._folder / source
        for root, _, files in os.walk(top):
            below = Path(root).relative_to(top).as_posix()
            for file in files:
                path = posixpath.normpath(posixpath.join(below, file))
                installed = posixpath.normpath(posixpath.join(target, path))
                entry = (installed, posixpath.normpath(posixpath.join(source, path)))
                self.installed.files.append(entry)
            self._files_left -= len(files)
            if self._files_left < 0:
                break


def _place(below: str, path: str) -> str:
    """Return a path in a script of a subfolder, relative to the folder of the first script."""
    if path == _TOP or path.startswith(f"{_TOP}/"):
        return posixpath.relpath(path, _TOP)
    return posixpath.normpath(posixpath.join(below, path))


def _split(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the words of a call before its options, and the options."""
    end = next((at for at, word in enumerate(words) if _OPTIONS.fullmatch(word)), len(words))
    return words[:end], words[end:]


def _value_after(option: str, words: list[str]) -> str | None:
    after = iter(words)
    return next(after, None) if option in after else None


def _end_of_loop(calls: list[tuple[str, str]], start: int) -> int:
    depth = 1
    for at in range(start, len(calls)):
        depth += {"foreach": 1, "endforeach": -1}.get(calls[at][0], 0)
        if not depth:
            return at
    return len(calls)


def _text_of(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
