"""How a service of simulation_interfaces answers: with a result code and words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.errors import NotFoundError, TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.node import Node
    from teleopctl.sim.entities.stage import Stage

Result = get_message("simulation_interfaces/msg/Result")

# Any, here and below: messages, whose classes are made at run time.
Handler = Callable[["Stage", Any, Any], None]


class Refusal(Exception):
    """Why a request is not done.

    Args:
        code: What its result is, of those that every service has or of the service's own.
        words: For people.
    """

    def __init__(self, code: int, words: str) -> None:
        super().__init__(words)
        self.code = code


class Desk:
    """Offers services on a node, and answers while there is no robot.

    Args:
        node: Whose services they are.
        stage: Returns what they work with, or None while there is no robot.
    """

    def __init__(self, node: Node, stage: Callable[[], Stage | None]) -> None:
        self.node = node
        self._stage = stage

    @property
    def stage(self) -> Stage:
        """What the services work with.

        Raises:
            Refusal: There is no robot yet.
        """
        stage = self._stage()
        if stage is None:
            raise Refusal(Result.RESULT_INCORRECT_STATE, "There is no robot yet")
        return stage

    def offer(self, type_name: str, name: str, handler: Handler) -> None:
        """Offer a service of simulation_interfaces.

        Args:
            type_name: Its type.
            name: Its name.
            handler: Takes the stage, the request and the response, whose result is OK unless it
                says otherwise.
        """

        def answer(request: Any, response: Any) -> Any:
            response.result.result = Result.RESULT_OK
            complain(response.result, lambda: handler(self.stage, request, response))
            return response

        self.node.create_service(
            get_service(f"simulation_interfaces/srv/{type_name}"), name, answer
        )


def existing(uri: str) -> Path:
    """Return the file or the folder that a URI names.

    Raises:
        NotFoundError: There is none.
    """
    path = resolve_uri(uri)
    try:
        if path.exists():
            return path
    except (OSError, ValueError) as error:
        raise NotFoundError(f"{uri} is no path") from error
    raise NotFoundError(f"There is no {path}")


def complain(result: Any, work: Callable[[], None]) -> None:
    """Do some work, and write into a result why it was not done."""
    try:
        work()
    except Refusal as refusal:
        result.result, result.error_message = refusal.code, str(refusal)
    except TeleopctlError as error:
        missing = isinstance(error, NotFoundError)
        result.result = Result.RESULT_NOT_FOUND if missing else Result.RESULT_OPERATION_FAILED
        result.error_message = f"{error.message} ({error.hint})" if error.hint else error.message
