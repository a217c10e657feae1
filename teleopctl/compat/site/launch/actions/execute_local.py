"""``launch.actions.execute_local``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.launch import Process, ProcessPlan

from .._texts import optional
from ..action import Action

if TYPE_CHECKING:
    from ..event_handlers.on_action_event_base import OnEvent
    from ..some_substitutions_type import SomeSubstitutionsType


class ExecuteLocal(Action):
    """Starts a process.

    Args:
        shell: Whether a shell reads the command line.
        sigterm_timeout: Seconds from SIGINT to SIGTERM.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL.
        emulate_tty: Accepted for ROS 2's sake: output comes unbuffered either way.
        output: ``screen``, ``log``, ``both`` …
        on_exit: What is done when it has ended, or a function that is called with event and
            context and may say so.
        respawn: Whether it is started again when it has ended.
        respawn_delay: Seconds to wait before that.
        respawn_max_retries: How often; negative for any number of times.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        *,
        shell: bool = False,
        sigterm_timeout: SomeSubstitutionsType | float | None = None,
        sigkill_timeout: SomeSubstitutionsType | float | None = None,
        emulate_tty: bool | SomeSubstitutionsType = False,  # noqa: ARG002
        output: SomeSubstitutionsType = "log",
        on_exit: OnEvent | None = None,
        respawn: bool | SomeSubstitutionsType = False,
        respawn_delay: float | SomeSubstitutionsType | None = None,
        respawn_max_retries: int | SomeSubstitutionsType = -1,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._settings: dict[str, Any] = {
            "shell": optional(shell),
            "sigterm_timeout": optional(sigterm_timeout),
            "sigkill_timeout": optional(sigkill_timeout),
            "output": optional(output),
            "respawn": optional(respawn),
            "respawn_delay": optional(respawn_delay),
            "respawn_max_retries": optional(respawn_max_retries),
        }
        self._on_exit = on_exit
        self._plan: ProcessPlan | None = None
        self._pid: int | None = None
        self._exit_status: int | None = None

    @property
    def process_details(self) -> dict[str, Any] | None:
        """What was started: action, name, cmd, cwd, env and, once it runs, pid; None before."""
        from ..events._model import details

        if self._plan is None:
            return None
        return details(Process(origin=self), self._plan, self._pid or 0)

    @property
    def return_code(self) -> int | None:
        """What the process ended with; None before."""
        return self._exit_status

    def planned(self, plan: ProcessPlan, launch: model.Launch) -> None:
        """Take in that it is going to be started."""
        from ..event_handlers.on_process_exit import OnProcessExit

        self._plan = plan
        if self._on_exit is not None:
            handler = OnProcessExit(target_action=self, on_exit=self._on_exit)
            launch.register(handler.model_handler())

    def process(self) -> Process:
        """Return what is started, as the model has it."""
        raise NotImplementedError

    def model_action(self) -> model.Action:
        """Return what the model does for it."""
        return _Start(self)


@dataclass(frozen=True, slots=True)
class _Start(model.Action):
    """Starts the process of an entity, and tells the entity of it."""

    entity: ExecuteLocal

    def evaluate(self, launch: model.Launch) -> None:
        """Start it."""
        plan = launch.start(self.entity.process())
        if not launch.is_trial:
            self.entity.planned(plan, launch)
