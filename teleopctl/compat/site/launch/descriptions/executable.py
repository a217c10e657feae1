"""``launch.descriptions.executable``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Executable as ModelExecutable, ProcessPart, ProcessPlan

from .._texts import optional, pairs, template
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..action import Action
    from ..launch_context import LaunchContext
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution

    Environment = Mapping[Any, SomeSubstitutionsType]
    Variables = list[tuple[list[Substitution], list[Substitution]]]


class Executable:
    """Command line with environment and working directory.

    Args:
        cmd: Program and arguments, one entry each.
        prefix: Words put before the command line.
        name: Name in the output instead of the program's.
        cwd: Folder to start in.
        env: Its whole environment; None for that of the launch.
        additional_env: Variables added to the environment.
        arguments: Further arguments.

    Attributes:
        settings: All but the command line, as the model has them.
    """

    def __init__(
        self,
        *,
        cmd: Iterable[SomeSubstitutionsType],
        prefix: SomeSubstitutionsType | None = None,
        name: SomeSubstitutionsType | None = None,
        cwd: SomeSubstitutionsType | None = None,
        env: Environment | None = None,
        additional_env: Environment | None = None,
        arguments: Iterable[SomeSubstitutionsType] | None = None,
    ) -> None:
        self._arguments = None if arguments is None else list(arguments)
        words = (*cmd, *(self._arguments or ()))
        self._cmd = [normalize_to_list_of_substitutions(word) for word in words]
        self._prefix = _normalized(prefix)
        self._name = _normalized(name)
        self._cwd = _normalized(cwd)
        self._env = _variables(env)
        self._additional_env = _variables(additional_env)
        self.settings: dict[str, Any] = {
            "process_name": optional(name),
            "prefix": optional(prefix),
            "working_directory": optional(cwd),
            "environment": (*pairs(env), *pairs(additional_env)),
            "clean_environment": env is not None,
        }
        self._plan: ProcessPlan | None = None
        self._final_env: dict[str, str] | None = None

    @property
    def name(self) -> list[Substitution] | None:
        """Name in the output instead of the program's, or None."""
        return self._name

    @property
    def prefix(self) -> list[Substitution] | None:
        """Words before the command line, or None."""
        return self._prefix

    @property
    def cmd(self) -> list[list[Substitution]]:
        """Program and arguments."""
        return self._cmd

    @property
    def cwd(self) -> list[Substitution] | None:
        """Working directory, or None."""
        return self._cwd

    @property
    def env(self) -> Variables | None:
        """Whole environment, or None."""
        return self._env

    @property
    def additional_env(self) -> Variables | None:
        """Variables added to the environment, or None."""
        return self._additional_env

    @property
    def arguments(self) -> list[SomeSubstitutionsType] | None:
        """Further arguments, or None."""
        return self._arguments

    @property
    def final_name(self) -> str | None:
        """Name in the output; None before evaluation."""
        return None if self._plan is None else self._plan.name

    @property
    def final_cmd(self) -> list[str] | None:
        """Evaluated program and arguments; None before evaluation."""
        return None if self._plan is None else self._plan.command

    @property
    def final_cwd(self) -> str | None:
        """Evaluated working directory; None before evaluation, or if it is the launch's."""
        return None if self._plan is None else self._plan.working_directory

    @property
    def final_env(self) -> dict[str, str] | None:
        """Evaluated environment; None before evaluation."""
        return self._final_env

    # Any: the settings of `ExecuteLocal`.
    def process(self, **settings: Any) -> ProcessPart:
        """Return the process as one of `teleopctl.launch`."""
        command = tuple(map(template, self._cmd))
        return ModelExecutable(command=command, **{**self.settings, **settings})

    def prepare(self, context: LaunchContext, action: Action | None) -> None:
        """Evaluate the command line, without starting it."""
        self.planned(context.launch.plan_of(self.process(origin=action)))

    def planned(self, plan: ProcessPlan) -> None:
        """Record the evaluated process."""
        from ..events._model import environment_of

        self._plan = plan
        self._final_env = environment_of(plan)


def _normalized(text: SomeSubstitutionsType | None) -> list[Substitution] | None:
    return None if text is None else normalize_to_list_of_substitutions(text)


def _variables(given: Environment | None) -> Variables | None:
    if given is None:
        return None
    normalized = normalize_to_list_of_substitutions
    return [(normalized(name), normalized(value)) for name, value in given.items()]
