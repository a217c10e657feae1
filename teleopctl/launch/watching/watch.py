"""What is saved is started again.

Whose own files were saved starts again (`sources`). Whose files the evaluation of the launch file
read, such as a robot description with all that it includes, is evaluated again, and the processes
that come out otherwise start again: the robot_state_publisher, for its parameter is another one.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import sys
from collections.abc import Iterable, Mapping, Set as AbstractSet
from dataclasses import replace
from pathlib import Path

from teleopctl.base.file_watch import FileWatch
from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import Evaluation, evaluate
from teleopctl.launch.execution.restarts import Restarts
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.plan import FollowUp, ProcessPlan
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.launch.watching.files_read import files_read
from teleopctl.launch.watching.sources import sources_of

_PARAMETERS = "--params-file"


class Watch:
    """Restarts processes of a launch when their source files are saved.

    Args:
        request: What was launched.
        evaluation: What evaluated it.
        restarts: Is told what to start again.
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
        # What was in the files when they were last looked at; None where there was none.
        self._known: dict[Path, bytes | None] = {}
        self._files = FileWatch(
            lambda files: restarts.call(lambda: self._saved(files)),
            lambda text: restarts.call(lambda: restarts.say("WARNING", text)),
        )

    def take_in(self, plans: Iterable[ProcessPlan]) -> None:
        """Watch the source files of further processes."""
        for plan in plans:
            self._sources[plan.name] = sources_of(plan, self._log_directory)
        files = self._read.union(*self._sources.values())
        known = self._known
        self._known = {file: known[file] if file in known else _digest(file) for file in files}
        self._files.watch(files)

    def close(self) -> None:
        """Stop watching."""
        self._files.close()

    def _saved(self, files: AbstractSet[Path]) -> None:
        changed = {file for file in files if file in self._known and self._is_new(file)}
        gone = {file for file in changed if self._known[file] is None}
        if gone:
            self._restarts.say("WARNING", f"{_named(gone)}: gone; what was made from it goes on")
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
        further = FollowUp()
        if changed & self._read:
            try:
                further = self._evaluate_again(changed)
            except TeleopctlError as error:
                self._keep(changed, str(error))
                self.take_in(())  # the mistake may stand in a file that was not read before
                return
        restarts = {**made_from, **{plan.name: plan for plan in self._others(further)}}
        self._restarts.say(
            "INFO", f"{_named(changed)} saved: {_named_plans(restarts) or 'nothing changes'}"
        )
        try:
            further.write_files()
        except OSError as error:
            self._restarts.say("ERROR", f"Cannot write {error.filename}: {error.strerror}")
            return
        for plan in restarts.values():
            self._restarts.restart(plan)
        self.take_in(restarts.values())

    def _keep(self, files: AbstractSet[Path], mistake: str) -> None:
        kept = "what runs goes on until the next save"
        self._restarts.say("ERROR", f"{_named(files)} saved; {kept}: {mistake}")

    def _is_new(self, file: Path) -> bool:
        before, self._known[file] = self._known[file], _digest(file)
        return self._known[file] != before

    def _sources_have(self, plan: ProcessPlan, files: AbstractSet[Path]) -> bool:
        return not files.isdisjoint(self._sources.get(plan.name, ()))

    def _evaluate_again(self, changed: AbstractSet[Path]) -> FollowUp:
        """Return what the launch would start now."""
        _forget_modules(changed)
        further = FollowUp()
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
                further = plan.start
        finally:
            self._read |= read
        return further

    def _others(self, further: FollowUp) -> list[ProcessPlan]:
        """The processes that would be other ones than those that are."""
        now = {plan.name: plan for plan in further.processes}
        return [
            now[plan.name]
            for plan in self._restarts.plans()
            if plan.name in now and _differs(plan, now[plan.name], further.files)
        ]


def _differs(before: ProcessPlan, now: ProcessPlan, files: Mapping[str, str]) -> bool:
    if _meant(before.command, {}) != _meant(now.command, files):
        return True
    return replace(before, command=[]) != replace(now, command=[])


def _meant(command: list[str], files: Mapping[str, str]) -> list[str]:
    """Return a command line with the content of parameter files in the place of their paths.

    Some launch files make a new one with each evaluation.
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
    """Return what keeps a Python file from being run, with file and line."""
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
    """Let modules be compiled anew; Python does not see a change of the same second and size."""
    for file in files:
        if file.suffix == ".py":
            with contextlib.suppress(OSError, NotImplementedError):
                Path(importlib.util.cache_from_source(str(file))).unlink()


def _forget_modules(files: AbstractSet[Path]) -> None:
    """Let modules that a launch file imports be read anew."""
    paths = set(map(str, files))
    for name, module in list(sys.modules.items()):
        if getattr(module, "__file__", None) in paths:
            del sys.modules[name]


def _named(files: Iterable[Path]) -> str:
    names = sorted(file.name for file in files)
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _named_plans(plans: Mapping[str, ProcessPlan]) -> str:
    if not plans:
        return ""
    return f"{', '.join(plans)} {'restarts' if len(plans) == 1 else 'restart'}"
