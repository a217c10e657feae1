"""``launch.actions.opaque_coroutine``."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.errors import TeleopctlError
from teleopctl.launch import dataclass

from ..action import Action
from ..event_handlers.on_shutdown import OnShutdown
from ..launch_context import LaunchContext
from ..utilities import ensure_argument_type

if TYPE_CHECKING:
    from concurrent.futures import Future

    from ..events.shutdown import Shutdown


class OpaqueCoroutine(Action):
    """Runs a coroutine; the launch waits for its end, and a shutdown cancels it.

    Args:
        coroutine: The coroutine function.
        args: Its arguments.
        kwargs: Its arguments by name.
        ignore_context: Whether it is not given the launch's context as the first one.
        left_over_kwargs: Further arguments of `Action`.

    Raises:
        TypeError: `coroutine` is no coroutine function.
    """

    # Any: arguments of the function.
    def __init__(
        self,
        *,
        coroutine: Callable[..., Coroutine[Any, Any, None]],
        args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None,
        ignore_context: bool = False,
        **left_over_kwargs: Any,
    ) -> None:
        super().__init__(**left_over_kwargs)
        import inspect  # takes 4 ms

        if not inspect.iscoroutinefunction(coroutine):
            raise TypeError(
                "OpaqueCoroutine expected a coroutine function for 'coroutine', "
                f"got '{type(coroutine)}'"
            )
        ensure_argument_type(args, (Iterable, type(None)), "args", "OpaqueCoroutine")
        ensure_argument_type(kwargs, (dict, type(None)), "kwargs", "OpaqueCoroutine")
        ensure_argument_type(ignore_context, bool, "ignore_context", "OpaqueCoroutine")
        self._coroutine = coroutine
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})
        self._ignore_context = ignore_context
        self._future: Future[None] | None = None

    def begin(
        self, context: LaunchContext, report: Callable[[TeleopctlError | None], None]
    ) -> None:
        """Start the coroutine, and report its end."""
        import asyncio

        from .._asyncio import told

        arguments = self._args if self._ignore_context else (context, *self._args)
        loop = context.asyncio_loop
        assert loop is not None
        self._future = asyncio.run_coroutine_threadsafe(
            self._coroutine(*arguments, **self._kwargs), loop
        )

        def has_ended(future: Future[None]) -> None:
            error = None if future.cancelled() else future.exception()
            self.tell_completion(context)
            report(told(error, self.describe()))

        self._future.add_done_callback(has_ended)

    def cancel(self, *_: Shutdown | LaunchContext) -> None:
        """Cancel the coroutine."""
        if self._future is not None:
            self._future.cancel()

    def done(self, context: LaunchContext) -> None:
        """Do nothing: the end of the coroutine completes the action."""

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        return _Begin(self)


@dataclass(frozen=True, slots=True)
class _Begin(model.Action):
    entity: OpaqueCoroutine

    def evaluate(self, launch: model.Launch) -> None:
        """Schedule the coroutine for the start of the processes."""
        if launch.is_trial:
            return
        context = LaunchContext.with_launch(launch)
        launch.work(_Coroutine(self.entity, context))
        launch.register(OnShutdown(on_shutdown=self.entity.cancel).model_handler())


@dataclass(frozen=True, slots=True)
class _Coroutine:
    entity: OpaqueCoroutine
    context: LaunchContext

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start the coroutine, and report its end."""
        self.entity.begin(self.context, report)
