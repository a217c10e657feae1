"""``launch.actions.execute_process``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Executable, Process

from .._texts import optional, template
from .execute_local import ExecuteLocal

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType

    Environment = Mapping[SomeSubstitutionsType, SomeSubstitutionsType]


class ExecuteProcess(ExecuteLocal):
    """Starts the process of a command line.

    Args:
        cmd: Program and arguments, one entry each.
        name: Its name in the output in place of the program's.
        prefix: Words put before the command line.
        cwd: Folder to start in.
        env: Its whole environment.
        additional_env: Variables added to the environment.
        kwargs: What `ExecuteLocal` takes.
    """

    # Any: the words of ExecuteLocal.
    def __init__(
        self,
        *,
        cmd: Iterable[SomeSubstitutionsType],
        name: SomeSubstitutionsType | None = None,
        prefix: SomeSubstitutionsType | None = None,
        cwd: SomeSubstitutionsType | None = None,
        env: Environment | None = None,
        additional_env: Environment | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._cmd = list(cmd)
        self._settings |= {
            "process_name": optional(name),
            "prefix": optional(prefix),
            "working_directory": optional(cwd),
            "environment": tuple(
                (template(variable), template(value))
                for variable, value in {**(env or {}), **(additional_env or {})}.items()
            ),
        }

    @property
    def cmd(self) -> list[SomeSubstitutionsType]:
        """Program and arguments, one entry each."""
        return self._cmd

    def process(self) -> Process:
        """Return what is started, as the model has it."""
        command = tuple(map(template, self._cmd))
        return Executable(command=command, origin=self, **self._settings)
