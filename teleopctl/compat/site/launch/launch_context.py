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
    """Protocol of substitutions."""

    def perform(self, context: LaunchContext, /) -> str:
        """Return the text."""
        ...


class _EventHandler(Protocol):
    """Protocol of event handlers."""

    def model_handler(self) -> Handler:
        """Return the corresponding handler of `teleopctl.launch`."""
        ...


class LaunchContext:
    """State of a launch under evaluation, for actions, substitutions and conditions.

    A context without a launch serves for experiments and tests.

    Args:
        argv: Words of the command line.
        noninteractive: Whether there is no terminal.
    """

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = False) -> None:
        state = State({}, Path())
        builder = ProcessBuilder(state, LaunchRequest(file=""))
        self.begin(Evaluation(state, builder), list(argv or ()), noninteractive)
        # The caller may change the environment between calls.
        self.launch.begin_user_code()

    def begin(self, launch: Evaluation, argv: list[str], noninteractive: bool) -> None:
        """Initialise the context for a launch."""
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
        """Return the context of an evaluation's state."""
        assert isinstance(context, State)
        assert context.launch is not None
        return cls.with_launch(context.launch)

    @classmethod
    def with_launch(cls, launch: Launch) -> LaunchContext:
        """Return the context of a launch, created at the first call."""
        assert isinstance(launch, Evaluation)
        known = launch.context.shown_as
        if not isinstance(known, cls):
            known = cls.__new__(cls)
            known.begin(launch, [], True)
            known._may_have_loop = True  # noqa: SLF001 -- of this class
            log_config.take_over(launch.context.log_directory)
        return known

    # Any: an object of a user's test that is used as a context.
    @classmethod
    @contextmanager
    def standing_for(cls, context: Any) -> Iterator[LaunchContext]:
        """Yield a context, or one with the configurations of an object that is used as one.

        Tests of launch files hand over objects of their own with ``launch_configurations``, which
        are written back at the end of the block.

        Args:
            context: A context, or an object that is used as one.
        """
        if isinstance(context, cls):
            yield context
            return
        known = cls()
        known.launch_configurations.update(context.launch_configurations)
        yield known
        context.launch_configurations.update(known.launch_configurations)

    def text(self, text: Template) -> str:
        """Return the value of a template."""
        return self.launch.text(text)

    def perform_substitution(self, substitution: _Substitution) -> str:
        """Return the value of a substitution."""
        return substitution.perform(self)

    # Any: launch files may store any value.
    @property
    def launch_configurations(self) -> MutableMapping[str, Any]:
        """Launch configurations by name; changes apply to the entities that follow."""
        return Configurations(self.launch)

    @property
    def environment(self) -> MutableMapping[str, str]:
        """Environment of processes; changes apply to the entities that follow."""
        return os.environ

    # Any: as in ROS 2.
    def get_locals_as_dict(self) -> dict[str, Any]:
        """Return the local and global variables of the context by name."""
        found: dict[str, Any] = {}
        if self.launch.file != Path():
            found["current_launch_file_path"] = str(self.launch.file)
            found["current_launch_file_directory"] = str(self.launch.file.parent)
        if self.launch.event is not None:
            found["event"] = event_of(self.launch.event, self.launch)
        return {**self._globals, **found, **self._locals}

    @property
    def locals(self) -> _Locals:
        """Local and global variables of the context, as attributes."""
        return _Locals(self.get_locals_as_dict())

    def extend_globals(self, extensions: dict[str, Any]) -> None:
        """Add global variables."""
        self._globals.update(extensions)

    def extend_locals(self, extensions: dict[str, Any]) -> None:
        """Add local variables."""
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
        """Remove at the end of the block the local variables that are added in it."""
        outer, self._locals = self._locals, dict(self._locals)
        try:
            yield
        finally:
            self._locals = outer

    @property
    def is_shutdown(self) -> bool:
        """Whether the launch is shutting down."""
        return self.launch.is_ending

    @property
    def asyncio_loop(self) -> asyncio.AbstractEventLoop | None:
        """Event loop of the launch's coroutines, on a thread of its own.

        None for a context that is there for trying things out.
        """
        if self._loop is None and self._may_have_loop:
            from ._asyncio import BackgroundLoop

            self._loop = BackgroundLoop()
        return self._loop

    def _set_asyncio_loop(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop

    def end_loop(self) -> None:
        """Stop the event loop, if the launch started it."""
        from ._asyncio import BackgroundLoop

        if isinstance(self._loop, BackgroundLoop):
            self._loop.end()
        self._loop = None

    # Any: the result of the future is not used.
    def add_completion_future(self, completion_future: asyncio.Future[Any]) -> None:
        """Add a future that the launch waits for before it ends."""
        from ._asyncio import Awaited

        self.launch.work(Awaited(completion_future, "a completion future"))

    def would_handle_event(self, event: Event) -> bool:
        """Return whether a registered handler matches an event."""
        return self.launch.has_handler_for(event)

    def register_event_handler(self, event_handler: _EventHandler, append: bool = False) -> None:
        """Register an event handler, before the others or after them."""
        self.launch.register(event_handler.model_handler(), last=append)

    def unregister_event_handler(self, event_handler: _EventHandler) -> None:
        """Unregister an event handler."""
        self.launch.unregister(event_handler.model_handler())

    def emit_event_sync(self, event: Event) -> None:
        """Queue an event; it is handled after the current step."""
        emit(event, self.launch)

    async def emit_event(self, event: Event) -> None:
        """Queue an event; it is handled after the current step."""
        self.emit_event_sync(event)


class _Locals:
    """Variables of a context, as attributes."""

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
