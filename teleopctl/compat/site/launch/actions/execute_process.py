"""``launch.actions.execute_process``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import split_command_line

from .._texts import template
from ..action import Action
from ..descriptions import Executable
from ..frontend.parse_substitution import substitutions_of
from .execute_local import ExecuteLocal

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution

    Environment = Mapping[Any, SomeSubstitutionsType]


class ExecuteProcess(ExecuteLocal):
    """Starts a process from a command line.

    Args:
        cmd: Program and arguments, one entry each.
        name: Name in the output instead of the program's.
        prefix: Words put before the command line.
        cwd: Folder to start in.
        env: Its whole environment.
        additional_env: Variables added to the environment.
        kwargs: Further arguments of `ExecuteLocal`.
    """

    # Any: arguments of `ExecuteLocal.`
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

    # Any, three times: see `Action.parse`.
    @classmethod
    def parse(
        cls, entity: Any, parser: Any, ignore: Collection[str] | None = None
    ) -> tuple[type[Action], dict[str, Any]]:
        """Return the class and its constructor arguments, parsed from a launch file.

        Args:
            entity: The element.
            parser: Parser of the launch file.
            ignore: Keys that a subclass reads itself.
        """
        return cls, parser.words_of(cls, entity, ignore or ())

    @classmethod
    def _parse_cmdline(cls, cmd: str, parser: Any) -> list[list[Substitution]]:
        words = split_command_line(template(parser.parse_substitution(cmd)))
        return [substitutions_of(word) for word in words]

    # Any: final texts once it is evaluated, and substitutions before.
    @property
    def name(self) -> Any:
        """Its name in the output."""
        return self._executable.final_name or self._executable.name

    @property
    def cmd(self) -> Any:
        """Program and arguments, as substitutions."""
        return self._executable.final_cmd or self._executable.cmd

    @property
    def cwd(self) -> Any:
        """Working directory."""
        return self._executable.final_cwd or self._executable.cwd

    @property
    def env(self) -> Any:
        """Its whole environment."""
        return self._executable.final_env or self._executable.env

    @property
    def additional_env(self) -> Any:
        """Variables added to the environment."""
        return self._executable.additional_env
