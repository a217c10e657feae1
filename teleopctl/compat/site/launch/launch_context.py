"""``launch.launch_context``."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, MutableMapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.errors import TeleopctlError
from teleopctl.launch import (
    Evaluation,
    Handler,
    Launch,
    LaunchContext as State,
    LaunchRequest,
    ProcessBuilder,
    Template,
)

from ._configurations import Configurations
from .event import Event, emit, event_of
from .logging import launch_config as log_config

if TYPE_CHECKING:
    import asyncio


class _Substitution(Protocol):
    """What stands for a text."""

    def perform(self, context: LaunchContext, /) -> str:
        """Return the text."""
        ...


class _EventHandler(Protocol):
    """What answers events."""

    def model_handler(self) -> Handler:
        """Return it as the model has it."""
        ...


class LaunchContext:
    """What actions, substitutions and conditions look at: a launch that is being evaluated.

    One that is made without a launch is for trying things out.

    Args:
        argv: Words of the command line.
        noninteractive: Whether there is no terminal.
    """

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = False) -> None:
        state = State({}, Path())
        builder = ProcessBuilder(state, LaunchRequest(file=""))
        self.begin(Evaluation(state, builder), list(argv or ()), noninteractive)
        # Whoever has it does with the environment what it likes, between its calls.
        self.launch.begin_user_code()

    def begin(self, launch: Evaluation, argv: list[str], noninteractive: bool) -> None:
        """Stand for a launch."""
        self.launch = launch
        launch.context.shown_as = self
        self.argv = argv
        self.noninteractive = noninteractive
        self._globals: dict[str, Any] = {}
        self._locals: dict[str, Any] = {}
        self._outer_locals: list[dict[str, Any]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._may_have_loop = False

    @classmethod
    def of(cls, context: object) -> LaunchContext:
        """Return the one that stands for an evaluation's state."""
        assert isinstance(context, State)
        assert context.launch is not None
        return cls.with_launch(context.launch)

    @classmethod
    def with_launch(cls, launch: Launch) -> LaunchContext:
        """Return the one that stands for a launch."""
        assert isinstance(launch, Evaluation)
        known = launch.context.shown_as
        if not isinstance(known, cls):
            known = cls.__new__(cls)
            known.begin(launch, [], True)
            known._may_have_loop = True  # noqa: SLF001 -- of this class
            log_config.take_over(launch.context.log_directory)
        return known

    def text(self, text: Template) -> str:
        """Evaluate a text of the model."""
        return self.launch.text(text)

    def perform_substitution(self, substitution: _Substitution) -> str:
        """Return the text that a substitution stands for."""
        return substitution.perform(self)

    # Any: launch files keep what they like there.
    @property
    def launch_configurations(self) -> MutableMapping[str, Any]:
        """Launch variables by name; what is set here is seen by what follows."""
        return Configurations(self.launch)

    @property
    def environment(self) -> MutableMapping[str, str]:
        """The environment as processes will see it; what is set here is seen by what follows."""
        return os.environ

    # Any: as in ROS 2.
    def get_locals_as_dict(self) -> dict[str, Any]:
        """Return what is known at this place, by name."""
        found: dict[str, Any] = {}
        if self.launch.file != Path():
            found["current_launch_file_path"] = str(self.launch.file)
            found["current_launch_file_directory"] = str(self.launch.file.parent)
        if self.launch.event is not None:
            found["event"] = event_of(self.launch.event, self.launch)
        return {**self._globals, **found, **self._locals}

    @property
    def locals(self) -> _Locals:
        """What is known at this place, as attributes."""
        return _Locals(self.get_locals_as_dict())

    def extend_globals(self, extensions: dict[str, Any]) -> None:
        """Add to what is known everywhere."""
        self._globals.update(extensions)

    def extend_locals(self, extensions: dict[str, Any]) -> None:
        """Add to what is known here."""
        self._locals.update(extensions)

    # These three pairs are what ROS 2's own actions use, and actions like them.
    def _push_locals(self) -> None:
        self._outer_locals.append(dict(self._locals))

    def _pop_locals(self) -> None:
        if not self._outer_locals:
            raise RuntimeError("locals stack unexpectedly empty")
        self._locals = self._outer_locals.pop()

    def _push_launch_configurations(self) -> None:
        self.launch.scope.push_configurations()

    def _pop_launch_configurations(self) -> None:
        self._bring_back(self.launch.scope.pop_configurations)

    def _push_environment(self) -> None:
        with self.launch.user_code():
            self.launch.scope.push_environment()

    def _pop_environment(self) -> None:
        self._bring_back(self.launch.scope.pop_environment)
        self.launch.apply_environment()

    def _bring_back(self, bring_back: Callable[[], None]) -> None:
        try:
            bring_back()
        except TeleopctlError as error:
            raise RuntimeError(error.message) from error

    @contextmanager
    def locals_kept(self) -> Iterator[None]:
        """Forget at the end of the block what it adds to what is known here."""
        outer, self._locals = self._locals, dict(self._locals)
        try:
            yield
        finally:
            self._locals = outer

    @property
    def is_shutdown(self) -> bool:
        """Whether the launch ends."""
        return self.launch.is_ending

    @property
    def asyncio_loop(self) -> asyncio.AbstractEventLoop | None:
        """The event loop of the launch's coroutines, which runs on a thread beside it.

        None for a context that is there for trying things out.
        """
        if self._loop is None and self._may_have_loop:
            from ._asyncio import BackgroundLoop

            self._loop = BackgroundLoop()
        return self._loop

    def _set_asyncio_loop(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop

    def end_loop(self) -> None:
        """Stop the event loop, where there is one of the launch's own."""
        from ._asyncio import BackgroundLoop

        if isinstance(self._loop, BackgroundLoop):
            self._loop.end()
        self._loop = None

    # Any: nobody cares for what it gives.
    def add_completion_future(self, completion_future: asyncio.Future[Any]) -> None:
        """Let the launch wait for something before it ends."""
        from ._asyncio import Awaited

        self.launch.work(Awaited(completion_future, "a completion future"))

    def would_handle_event(self, event: Event) -> bool:
        """Tell whether a handler would answer an event."""
        return self.launch.has_handler_for(event)

    def register_event_handler(self, event_handler: _EventHandler, append: bool = False) -> None:
        """Let a handler answer events: before those that are there, or after them."""
        self.launch.register(event_handler.model_handler(), last=append)

    def unregister_event_handler(self, event_handler: _EventHandler) -> None:
        """Let a handler answer no more events."""
        self.launch.unregister(event_handler.model_handler())

    def emit_event_sync(self, event: Event) -> None:
        """Make an event happen once this is done."""
        emit(event, self.launch)

    async def emit_event(self, event: Event) -> None:
        """Make an event happen once this is done."""
        self.emit_event_sync(event)


class _Locals:
    """What is known at a place, as attributes."""

    # Any: as in ROS 2.
    def __init__(self, known: dict[str, Any]) -> None:
        vars(self).update(known)

    def __getattr__(self, name: str) -> Any:
        known = ", ".join(vars(self))
        raise AttributeError(
            f"context.locals does not contain attribute '{name}', it contains: [{known}]"
        )

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"can't set attribute '{name}', locals are read-only")
