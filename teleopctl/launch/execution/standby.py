"""Standby process of the simulator, which imports its modules while a launch file is evaluated."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

from teleopctl.base import interrupts, progress, standby
from teleopctl.base.output import LOG_FILE
from teleopctl.base.typed import TYPE_CHECKING, Iterator, Mapping
from teleopctl.launch.execution.streams import stream
from teleopctl.launch.model.plan import ProcessPlan

if TYPE_CHECKING:
    from typing import IO


_PYTHON = [sys.executable, "-P", "-m", "teleopctl.nodes"]
_PROGRAM = ["mujoco_sim", "mujoco_sim"]
# What a launch file that starts the simulator contains, itself or for an included file.
_NAMES_IN_FILES = (b"mujoco_sim", b"sim.yaml")
# Restricts the search for the program, which the process repeats with its arguments.
_BUILTIN = "--builtin"
# Variables of each process of a launch, which are read once its arguments are known.
_READ_LATER = {progress.VARIABLE, LOG_FILE}


class StandbyProcess:
    """Process of the simulator that waits for its arguments, with pipes for its output.

    Args:
        process: Process, whose standard input is a pipe.
        output: Reading ends of the pipes of stdout and stderr.
        environment: Environment variables of the process.
    """

    def __init__(
        self,
        process: subprocess.Popen[bytes],
        output: tuple[IO[bytes], IO[bytes]],
        environment: Mapping[str, str],
    ) -> None:
        self._process = process
        self._output = output
        self._environment = dict(environment)
        self._is_waiting = True

    def take(
        self, plan: ProcessPlan, environment: Mapping[str, str]
    ) -> tuple[subprocess.Popen[bytes], tuple[IO[bytes], IO[bytes]]] | None:
        """Let the process begin the work of a plan; return it and its output, None if unfit.

        Args:
            plan: Plan of a process, of the simulator or of another program.
            environment: Environment variables for the plan. Python and the imported modules have
                read those that they need, so they must be those of this process.
        """
        words = [word for word in plan.command[: len(_PYTHON) + 3] if word != _BUILTIN]
        differing = {
            name
            for name in {*environment, *self._environment}
            if environment.get(name) != self._environment.get(name)
        }
        is_fit = (
            words[: len(_PYTHON) + len(_PROGRAM)] == _PYTHON + _PROGRAM
            and differing <= _READ_LATER
            and plan.is_node
            and not (plan.shell or plan.emulate_tty or plan.working_directory)
        )
        if not (is_fit and self._is_waiting and self._process.poll() is None):
            return None
        self._is_waiting = False
        assert self._process.stdin is not None
        # The exit status of a process that has ended meanwhile is reported like any other.
        with contextlib.suppress(OSError):
            standby.send_order(self._process.stdin, plan.command[len(_PYTHON) :], environment)
        return self._process, self._output

    def close(self) -> None:
        """End the process, unless it has begun its work."""
        if not self._is_waiting:
            return
        self._is_waiting = False
        self._process.kill()
        for pipe in (self._process.stdin, *self._output):
            if pipe is not None:
                pipe.close()
        self._process.wait()


@contextlib.contextmanager
def standby_simulator(file: Path) -> Iterator[StandbyProcess | None]:
    """Context manager with a standby process, if a launch file names the simulator; else None.

    The process ends with the block, unless it has begun its work.
    """
    try:
        text = file.read_bytes()
        names_simulator = any(name in text for name in _NAMES_IN_FILES)
    except OSError:
        names_simulator = False  # the evaluation reports it
    if not names_simulator:
        yield None
        return
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with interrupts.blocked_for_children(), stream() as out, stream() as err:
        process = subprocess.Popen(
            [*_PYTHON, _BUILTIN, *_PROGRAM],
            env={**environment, standby.VARIABLE: "1"},
            stdin=subprocess.PIPE,
            stdout=out.written,
            stderr=err.written,
            restore_signals=False,
            **interrupts.own_group(),
        )
        found = StandbyProcess(process, (out.read(), err.read()), environment)
    with contextlib.closing(found):
        yield found
