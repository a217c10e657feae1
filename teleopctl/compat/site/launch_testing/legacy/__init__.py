"""``launch_testing.legacy``: test processes, and tests of the output of processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from launch import LaunchDescription, LaunchService
from launch.actions import EmitEvent, ExecuteLocal, RegisterEventHandler
from launch.event_handlers import OnExecutionComplete, OnProcessExit, OnProcessIO, OnShutdown
from launch.events import Shutdown

from . import output

if TYPE_CHECKING:
    from launch import Action, LaunchContext
    from launch.events.process import ProcessExited, ProcessIO

    Answer = list[EmitEvent] | None

_ARMED, _PASSED, _FAILED, _DROPPED = "armed", "passed", "failed", "dropped"


class LaunchTestService:
    """Runs a launch description with test actions; returns the exit status."""

    def __init__(self) -> None:
        self._tests: dict[str, str] = {}
        self._statuses: dict[str, int] = {}

    def add_fixture_action(
        self,
        launch_description: LaunchDescription,
        action: Action,
        exit_allowed: Sequence[int] | bool = (0,),
    ) -> Action:
        """Add an action that the tests need; its exit ends the launch.

        Args:
            launch_description: Launch description to add it to.
            action: Action to add and return.
            exit_allowed: Exit statuses with which it may end, or whether it may with any.
        """
        launch_description.add_action(action)
        if isinstance(action, ExecuteLocal):

            def has_ended(event: ProcessExited, context: LaunchContext) -> Answer:
                may = exit_allowed
                if not isinstance(may, bool):
                    may = event.returncode in may
                if may or context.is_shutdown:
                    return None
                self._statuses[event.process_name] = event.returncode or 1
                return _shut_down(f"{event.process_name} fixture process died!")

            _on_exit(launch_description, action, has_ended)
        return action

    def add_test_action(self, launch_description: LaunchDescription, action: Action) -> Action:
        """Add a test: a process that must exit with 0, or an action whose future must not raise.

        The launch ends when one has failed, or all have ended.

        Args:
            launch_description: Launch description to add it to.
            action: Action to add and return.
        """
        test = f"test_{id(action)}"
        if isinstance(action, ExecuteLocal):

            def has_ended(event: ProcessExited, _: LaunchContext) -> Answer:
                if event.returncode == 0:
                    return self._passed(test)
                self._statuses[event.process_name] = event.returncode
                return self._failed(test, f"{event.process_name} test failed!")

            _on_exit(launch_description, action, has_ended)
        else:

            def is_complete(event: Any, _: LaunchContext) -> Answer:
                future = event.action.get_asyncio_future()
                if future is not None and future.cancelled():
                    self._tests[test] = _DROPPED
                    return None
                error = future.exception() if future is not None else None
                return self._passed(test) if error is None else self._failed(test, str(error))

            launch_description.add_action(
                RegisterEventHandler(
                    OnExecutionComplete(target_action=action, on_completion=is_complete)
                )
            )
        launch_description.add_action(action)
        self._tests[test] = _ARMED
        return action

    # Any: what `output.create_output_lines_test` and the like return.
    def add_output_test(
        self,
        launch_description: LaunchDescription,
        action: ExecuteLocal,
        output_test: tuple[Any, Callable[..., Any], Callable[..., bool], Sequence[Any]],
        test_suffix: str = "output",
        output_filter: Callable[[bytes], bytes] | None = None,
        side_effect: str | None = None,
    ) -> ExecuteLocal:
        """Add a test of a process's output on stdout.

        Args:
            launch_description: Launch description with the action.
            action: Starts the process; it is returned.
            output_test: Return value of `output.create_output_test_from_file` and the like.
            test_suffix: Distinguishes several tests of one process.
            output_filter: Function applied to the output before.
            side_effect: ``shutdown`` where the launch ends once it has passed.
        """
        test = f"test_{id(action)}_{test_suffix}"
        written, collate, match, missing = output_test
        self._tests[test] = _ARMED

        def has_written(event: ProcessIO) -> Answer:
            nonlocal written, missing
            text = event.text if output_filter is None else output_filter(event.text)
            written = collate(written, text)
            missing = [pattern for pattern in missing if not match(written, pattern)]
            return None if missing else self._passed(test, side_effect)

        def ends(*_: object) -> None:
            if missing and self._tests[test] == _ARMED:
                self._tests[test] = _FAILED

        launch_description.add_action(
            RegisterEventHandler(OnProcessIO(target_action=action, on_stdout=has_written))
        )
        _on_exit(launch_description, action, lambda *_: self._ended_if_nothing_is_left(but=test))
        launch_description.add_action(RegisterEventHandler(OnShutdown(on_shutdown=ends)))
        return action

    # Any: arguments of `LaunchService.run.`
    def run(self, launch_service: LaunchService, *args: Any, **kwargs: Any) -> int:
        """Run the launch; return its exit status or, if 0, that of the first failed test.

        Args:
            launch_service: Has been given the launch description.
            args: Further arguments of `LaunchService.run`.
            kwargs: Likewise.
        """
        status = launch_service.run(*args, **kwargs)
        failed = int(_FAILED in self._tests.values())
        return status or next(iter(self._statuses.values()), failed)

    def _passed(self, test: str, side_effect: str | None = None) -> Answer:
        self._tests[test] = _PASSED
        if side_effect == "shutdown":
            return _shut_down("shutdown after test")
        return self._ended_if_nothing_is_left()

    def _failed(self, test: str, reason: str) -> Answer:
        self._tests = {
            name: _DROPPED if state == _ARMED else state for name, state in self._tests.items()
        } | {test: _FAILED}
        return _shut_down(reason)

    def _ended_if_nothing_is_left(self, but: str | None = None) -> Answer:
        armed = {name for name, state in self._tests.items() if state == _ARMED} - {but}
        return None if armed else _shut_down("all tests finished")


def _on_exit(
    description: LaunchDescription, action: ExecuteLocal, answer: Callable[..., Answer]
) -> None:
    description.add_action(
        RegisterEventHandler(OnProcessExit(target_action=action, on_exit=answer))
    )


def _shut_down(reason: str) -> list[EmitEvent]:
    return [EmitEvent(event=Shutdown(reason=reason))]


__all__ = ["LaunchTestService", "output"]
