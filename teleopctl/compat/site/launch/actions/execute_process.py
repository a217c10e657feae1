"""``launch.actions.execute_process``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from ..descriptions import Executable
from .execute_local import ExecuteLocal

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType

    Environment = Mapping[Any, SomeSubstitutionsType]


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
        prefix: SomeSubstitutionsType | None = None,
        name: SomeSubstitutionsType | None = None,
        cwd: SomeSubstitutionsType | None = None,
        env: Environment | None = None,
        additional_env: Environment | None = None,
        **kwargs: Any,
    ) -> None:
        description = Executable(
            cmd=cmd, prefix=prefix, name=name, cwd=cwd, env=env, additional_env=additional_env
        )
        super().__init__(process_description=description, **kwargs)
        self._executable = description
        self._settings |= description.settings

    # Any: final texts once it is evaluated, and substitutions before.
    @property
    def name(self) -> Any:
        """Its name in the output."""
        return self._executable.final_name or self._executable.name

    @property
    def cmd(self) -> Any:
        """Program and arguments."""
        return self._executable.final_cmd or self._executable.cmd

    @property
    def cwd(self) -> Any:
        """The folder to start in."""
        return self._executable.final_cwd or self._executable.cwd

    @property
    def env(self) -> Any:
        """Its whole environment."""
        return self._executable.final_env or self._executable.env

    @property
    def additional_env(self) -> Any:
        """Variables added to the environment."""
        return self._executable.additional_env
