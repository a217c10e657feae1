"""Base of the simulator's services: offering, result codes and error messages."""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import NotFoundError, RefusedError, TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.packages import resolve_uri
from teleopctl.robot import find_world

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.running_simulation import RunningSimulation

Result = get_message("simulation_interfaces/msg/Result")
_TagsFilter = get_message("simulation_interfaces/msg/TagsFilter")

# Any, here and below: messages, whose classes are made at run time. Handlers that take long are
# coroutines.
Handler = Callable[["RunningSimulation", Any, Any], "Awaitable[None] | None"]
WordHandler = Callable[["RunningSimulation", Any], "Awaitable[str] | str"]
FindRunning = Callable[[], "RunningSimulation | None"]
"""Function that returns the running simulation, or None while there is no robot."""

# URI schemes of models in Gazebo's model folders, and of Fuel's models in Gazebo's cache.
_GAZEBO_SCHEMES = frozenset({"model", "http", "https"})

NO_ROBOT = "There is no robot yet"


class Refusal(Exception):
    """Exception with which a service handler refuses a request: result code and response message.

    Args:
        code: Result code, one of those of all services or of the service's own.
        words: Error message of the response.
    """

    def __init__(self, code: int, words: str) -> None:
        super().__init__(words)
        self.code = code


class SimulationServices:
    """Creator of simulation_interfaces services on a node, which refuse calls without a robot.

    Args:
        node: Node of the services.
        find_running: See `FindRunning`.
    """

    def __init__(self, node: Node, find_running: FindRunning) -> None:
        self.node = node
        self._find_running = find_running

    @property
    def running(self) -> RunningSimulation:
        """The running simulation that the services act on; `Refusal` is raised without a robot.

        Raises:
            Refusal: There is no robot yet.
        """
        running = self._find_running()
        if running is None:
            raise Refusal(Result.RESULT_INCORRECT_STATE, NO_ROBOT)
        return running

    def offer(self, type_name: str, name: str, handler: Handler) -> None:
        """Create a simulation_interfaces service answered by a handler, with errors as its result.

        Args:
            type_name: Type of the service, in simulation_interfaces.
            name: Name of the service.
            handler: Called with the running simulation, the request and the response, whose result
                is OK unless the handler sets or raises another one.
        """

        async def answer(request: Any, response: Any) -> Any:
            with self.answering(response.result):
                outcome = handler(self.running, request, response)
                if outcome is not None:
                    await outcome
            return response

        self.node.create_service(
            get_service(f"simulation_interfaces/srv/{type_name}"), name, answer
        )

    @contextlib.contextmanager
    def answering(self, result: Any) -> Iterator[None]:
        """Set a Result message to OK, or to the ``with`` block's error, which is suppressed."""
        result.result = Result.RESULT_OK
        try:
            yield
        except Refusal as refusal:
            result.result, result.error_message = refusal.code, str(refusal)
        except NotFoundError as error:
            result.result, result.error_message = Result.RESULT_NOT_FOUND, error_text(error)
        except Exception as error:  # noqa: BLE001 - no request ends the simulation
            result.result = Result.RESULT_OPERATION_FAILED
            result.error_message = failure_text(self.node, error)


def offer_message_service(
    node: Node, find_running: FindRunning, type_name: str, name: str, handler: WordHandler
) -> None:
    """Create a mujoco_ros2_control_msgs service; its handler returns the text of the response.

    Args:
        node: Node of the service.
        find_running: See `FindRunning`.
        type_name: Type of the service, in mujoco_ros2_control_msgs.
        name: Name of the service.
        handler: Called with the running simulation and the request; returns the message.
    """

    async def answer(request: Any, response: Any) -> Any:
        try:
            running = find_running()
            if running is None:
                raise RefusedError(NO_ROBOT)
            outcome = handler(running, request)
            response.message = outcome if isinstance(outcome, str) else await outcome
            response.success = True
        except Exception as error:  # noqa: BLE001 - no request ends the simulation
            response.success, response.message = False, failure_text(node, error)
        return response

    node.create_service(get_service(f"mujoco_ros2_control_msgs/srv/{type_name}"), name, answer)


def error_text(error: TeleopctlError) -> str:
    """Return the message of an error, with its hint in parentheses if there is one."""
    return f"{error.message} ({error.hint})" if error.hint else error.message


def failure_text(node: Node, error: Exception) -> str:
    """Return an exception's text for a service response; log the traceback of an unexpected one."""
    if isinstance(error, TeleopctlError):
        return error_text(error)
    node.get_logger().error("".join(traceback.format_exception(error)))
    return f"{type(error).__name__}: {error}"


def has_tags(tags: list[str], wanted: Any) -> bool:
    """Return whether tags pass a TagsFilter message (any or all of its tags); true if empty."""
    if not wanted.tags:
        return True
    every = wanted.filter_mode == _TagsFilter.FILTER_MODE_ALL
    return (all if every else any)(tag in tags for tag in wanted.tags)


def existing_path(uri: str) -> Path:
    """Return the local path of a URI if a file or folder is there; raise otherwise.

    Raises:
        NotFoundError: There is no such file or folder.
    """
    path = resolve_uri(uri)
    try:
        if path.is_file() or path.is_dir():
            return path
    except OSError as error:
        raise NotFoundError(f"Cannot open {path}: {error.strerror}") from error
    raise NotFoundError(f"There is no file {path}")


def description_at(uri: str) -> Path:
    """Return the path of the description file that a URI names, or that of a named model folder.

    Raises:
        NotFoundError: There is no such file.
    """
    if uri.partition("://")[0] in _GAZEBO_SCHEMES:
        path = existing_path(str(find_world(uri, Path.cwd())))
    else:
        path = existing_path(uri)
    return find_world(str(path), Path.cwd()) if path.is_dir() else path


def files_at(source: str) -> list[Path]:
    """Return paths: the file that a URI names, or the files in the named folder; empty if none."""
    try:
        path = existing_path(source)
        return (
            [each for each in sorted(path.iterdir()) if each.is_file()] if path.is_dir() else [path]
        )
    except (NotFoundError, OSError):
        return []
