"""Restart of processes whose source files were saved (``launch --watch``).

A process restarts when one of its files is saved, such as its program or its parameter file. When a
file is saved that the evaluation of the launch file has read, such as a robot description or a file
that it includes, the launch file is evaluated again. Then the processes restart whose command
lines, parameters or environments differ.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import re
import shlex
import sys
import sysconfig
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Set as AbstractSet
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from teleopctl.base.file_watch import FileWatch
from teleopctl.base.typed import Any
from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import Evaluation, evaluate
from teleopctl.launch.execution.restarts import Restarts
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.plan import FollowUp, ProcessPlan
from teleopctl.launch.model.records import replace
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.packages import (
    PackageProgram,
    find_executable,
    installed_module_roots,
    is_path,
    lookup_package,
    run_dependencies,
    source_module_root,
)

# The search for packages reads hundreds of these files, which do not affect processes.
_OF_PACKAGES = frozenset(
    {"package.xml", "setup.py", "setup.cfg", "pyproject.toml", "CMakeLists.txt", "pyvenv.cfg"}
)
_WRITES = os.O_WRONLY | os.O_RDWR

_note: Callable[[str, bool], object] | None = None
_thread = 0
_is_installed = False


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """Yield a set; at the end of the ``with`` block, it gets the user's files that were read.

    Files that the block itself writes are left out, since each evaluation would write them again.
    """
    global _note, _thread
    found: set[Path] = set()
    read: set[str] = set()
    written: set[str] = set()
    _install()
    _note, _thread = (
        lambda path, writes: (written if writes else read).add(path),
        (threading.get_ident()),
    )
    try:
        yield found
    finally:
        _note = None
        paths = {Path(_source(path)).absolute() for path in read - written}
        found.update(path for path in paths if is_user_file(path) and path.is_file())


def is_user_file(path: Path) -> bool:
    """Return whether a file is the user's: not of Python, a library or teleopctl."""
    return path.name not in _OF_PACKAGES and not any(map(path.is_relative_to, _excluded_folders()))


@cache
def _excluded_folders() -> tuple[Path, ...]:
    installed = sysconfig.get_paths()
    folders = [installed[key] for key in ("stdlib", "platstdlib", "purelib", "platlib")]
    own = Path(__file__).parents[1]
    return (*map(Path, dict.fromkeys(folders)), own, Path("/proc"), Path("/sys"), Path("/dev"))


def _source(path: str) -> str:
    """Return the source path of a compiled module's path; any other path unchanged."""
    if path.endswith(".pyc"):
        try:
            return importlib.util.source_from_cache(path)
        except ValueError:
            return path
    return path


def _install() -> None:
    # An audit hook cannot be removed; so only a launch with ``--watch`` installs one.
    global _is_installed
    if not _is_installed:
        _is_installed = True
        sys.addaudithook(_on_event)


# Any: the arguments depend on the event.
def _on_event(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or _note is None or _thread != threading.get_ident():
        return
    path, _, flags = arguments
    if isinstance(path, bytes):
        path = os.fsdecode(path)
    if isinstance(path, str):
        _note(path, bool(flags & _WRITES))


_NODES = "teleopctl.nodes"
_PARAMETERS = "--params-file"
# Suffixes of arguments that a program reads; other arguments, such as a bag, may be written.
_READ = frozenset({".py", ".rviz", ".sdf", ".srdf", ".urdf", ".xacro", ".xml", ".yaml", ".yml"})
_NO_SOURCES = frozenset({"build", "install", "launch", "log", "test", "tests", "__pycache__"})


def sources_of(plan: ProcessPlan, log_directory: Path) -> frozenset[Path]:
    """Return the user's files that a process depends on: program, modules, parameters, scripts.

    Modules are the Python modules of the program's package and of that package's dependencies.
    Scripts include the robot descriptions and other source files that the command line names.

    Args:
        plan: Plan of the process.
        log_directory: Log folder of the launch, whose files are left out.
    """
    words = plan.command
    if plan.shell:
        try:
            words = shlex.split(words[0])
        except ValueError:
            return frozenset()
    found = {*_files_named_by(words, plan.working_directory), *_of_program(words)}
    return frozenset(
        path for path in found if is_user_file(path) and not path.is_relative_to(log_directory)
    )


def _files_named_by(words: list[str], folder: str | None) -> Iterator[Path]:
    before = ""
    for word in words:
        path = Path(os.path.normpath(os.path.join(folder or "", word))).absolute()  # noqa: PTH118
        if (before == _PARAMETERS or path.suffix in _READ) and path.is_file():
            yield path
        before = word


def _of_program(words: list[str]) -> Iterator[Path]:
    if _NODES not in words:
        return
    rest = words[words.index(_NODES) + 1 :]
    try:
        if rest and is_path(rest[0]):
            yield from _of_executable(find_executable(None, rest[0]))
        elif len(rest) > 1 and rest[0] != "--builtin":
            yield from _of_executable(find_executable(rest[0], rest[1]))
    except TeleopctlError:
        # The program existed at the evaluation; its files are watched again when it is back.
        return


def _of_executable(executable: PackageProgram) -> Iterator[Path]:
    if executable.file is not None:
        yield executable.file
    if executable.target and not executable.import_roots:
        yield from _of_module(executable.target)
    package = lookup_package(executable.package) if executable.package else None
    if package is None:
        return
    roots = [] if executable.target and not executable.import_roots else [package.folder]
    roots += [root / package.name for root in installed_module_roots(package.name)]
    try:
        manifest = (package.folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        manifest = ""
    for name in run_dependencies(manifest):
        root = source_module_root(name)
        roots += [] if root is None else [root / name]
    for root in roots:
        yield from _modules_below(root)


def _of_module(target: str) -> Iterator[Path]:
    """Yield the sources of a module of a distribution that is installed by ``pip install -e``."""
    try:
        spec = importlib.util.find_spec(re.split("[.:]", target)[0])
    except (ImportError, ValueError):
        return
    if spec is None or spec.origin is None or not is_user_file(Path(spec.origin)):
        return
    if spec.submodule_search_locations is None:
        yield Path(spec.origin)
    for folder in spec.submodule_search_locations or ():
        yield from _modules_below(Path(folder))


def _modules_below(root: Path) -> Iterator[Path]:
    for folder, below, files in os.walk(root):
        below[:] = [name for name in below if name[0] != "." and name not in _NO_SOURCES]
        yield from (Path(folder, name) for name in files if name.endswith(".py"))


class Watch:
    """Watcher that restarts processes of a launch when their source files are saved.

    Args:
        request: Launch file with its arguments and options.
        evaluation: Evaluation of the launch file.
        restarts: Restarts of the launch's processes.
    """

    def __init__(
        self,
        request: LaunchRequest,
        evaluation: Evaluation,
        restarts: Restarts,
    ) -> None:
        self._request = request
        self._log_directory = evaluation.context.log_directory
        self._evaluation = evaluation
        self._read = evaluation.files_read
        self._restarts = restarts
        self._sources: dict[str, frozenset[Path]] = {}
        # Digests of the files when they were last read; None for a missing file.
        self._known: dict[Path, bytes | None] = {}
        self._files = FileWatch(
            lambda files: restarts.call(lambda: self._saved(files)),
            lambda text: restarts.call(lambda: restarts.log("WARNING", text)),
        )

    def watch_sources(self, plans: Iterable[ProcessPlan]) -> None:
        """Also watch the source files of processes, to restart a process when one changes."""
        for plan in plans:
            self._sources[plan.name] = sources_of(plan, self._log_directory)
        files = self._read.union(*self._sources.values())
        known = self._known
        self._known = {file: known[file] if file in known else _digest(file) for file in files}
        self._files.watch(files)

    def close(self) -> None:
        """Stop watching all files."""
        self._files.close()

    def _saved(self, files: AbstractSet[Path]) -> None:
        changed = {file for file in files if file in self._known and self._is_new(file)}
        gone = {file for file in changed if self._known[file] is None}
        if gone:
            self._restarts.log(
                "WARNING", f"{_list_names(gone)}: gone; the processes made from it keep running"
            )
        for file in sorted(changed - gone):
            mistake = _mistake(file)
            if mistake is not None:
                self._keep({file}, mistake)
                gone.add(file)
        changed -= gone
        if not changed:
            return
        _forget_compiled(changed)
        made_from = {
            plan.name: plan for plan in self._restarts.plans() if self._sources_have(plan, changed)
        }
        follow_up = FollowUp()
        if changed & self._read:
            try:
                follow_up = self._evaluate_again(changed)
            except TeleopctlError as error:
                self._keep(changed, str(error))
                self.watch_sources(())  # the error may be in a file that was not read before
                return
        restarts = {**made_from, **{plan.name: plan for plan in self._changed_plans(follow_up)}}
        self._restarts.log(
            "INFO", f"{_list_names(changed)} saved: {_named_plans(restarts) or 'nothing changes'}"
        )
        try:
            follow_up.write_files()
        except OSError as error:
            self._restarts.log("ERROR", f"Cannot write {error.filename}: {error.strerror}")
            return
        for plan in restarts.values():
            self._restarts.restart(plan)
        self.watch_sources(restarts.values())

    def _keep(self, files: AbstractSet[Path], mistake: str) -> None:
        kept = "running processes stay until the next save"
        self._restarts.log("ERROR", f"{_list_names(files)} saved; {kept}: {mistake}")

    def _is_new(self, file: Path) -> bool:
        before, self._known[file] = self._known[file], _digest(file)
        return self._known[file] != before

    def _sources_have(self, plan: ProcessPlan, files: AbstractSet[Path]) -> bool:
        return not files.isdisjoint(self._sources.get(plan.name, ()))

    def _evaluate_again(self, changed: AbstractSet[Path]) -> FollowUp:
        """Return the first steps of a new evaluation of the launch file."""
        _forget_modules(changed)
        follow_up = FollowUp()
        read: set[Path] = set()
        try:
            with files_read() as read, self._restarts.evaluating():
                plan, _ = evaluate(
                    read_launch_file(Path(self._request.file)),
                    self._request.arguments,
                    self._log_directory,
                    self._request,
                    again=self._evaluation,
                )
                follow_up = plan.start
        finally:
            self._read |= read
        return follow_up

    def _changed_plans(self, follow_up: FollowUp) -> list[ProcessPlan]:
        """Return the new plans of those processes whose plans differ from the running ones."""
        now = {plan.name: plan for plan in follow_up.processes}
        return [
            now[plan.name]
            for plan in self._restarts.plans()
            if plan.name in now and _differs(plan, now[plan.name], follow_up.files)
        ]


def _differs(before: ProcessPlan, now: ProcessPlan, files: Mapping[str, str]) -> bool:
    if _with_parameter_contents(before.command, {}) != _with_parameter_contents(now.command, files):
        return True
    return replace(before, command=[]) != replace(now, command=[])


def _with_parameter_contents(command: list[str], files: Mapping[str, str]) -> list[str]:
    """Return a command line with the content of parameter files in the place of their paths.

    Some launch files write a parameter file with a new name at each evaluation.
    """
    words = list(command)
    for index, word in enumerate(words[:-1]):
        path = words[index + 1]
        if word == _PARAMETERS:
            words[index + 1] = files.get(path) or _text(Path(path))
    return words


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _digest(file: Path) -> bytes | None:
    try:
        return hashlib.blake2b(file.read_bytes(), usedforsecurity=False).digest()
    except OSError:
        return None


def _mistake(file: Path) -> str | None:
    """Return the syntax error or read error of a Python file, with file and line; or None."""
    if file.suffix != ".py":
        return None
    try:
        compile(file.read_bytes(), str(file), "exec", dont_inherit=True)
    except SyntaxError as error:
        return f"{error.filename}:{error.lineno}: {error.msg}"
    except (OSError, ValueError) as error:
        return f"{file}: {error}"
    return None


def _forget_compiled(files: AbstractSet[Path]) -> None:
    """Delete compiled modules; Python misses a change within a second that keeps the size."""
    for file in files:
        if file.suffix == ".py":
            with contextlib.suppress(OSError, NotImplementedError):
                Path(importlib.util.cache_from_source(str(file))).unlink()


def _forget_modules(files: AbstractSet[Path]) -> None:
    """Remove the modules of changed files from `sys.modules`, so that they are imported again."""
    paths = set(map(str, files))
    for name, module in list(sys.modules.items()):
        if getattr(module, "__file__", None) in paths:
            del sys.modules[name]


def _list_names(files: Iterable[Path]) -> str:
    names = sorted(file.name for file in files)
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _named_plans(plans: Mapping[str, ProcessPlan]) -> str:
    if not plans:
        return ""
    return f"{', '.join(plans)} {'restarts' if len(plans) == 1 else 'restart'}"
