"""Protocols of interface classes for type checkers; imported for annotations only."""

from __future__ import annotations

from collections.abc import Iterator

from teleopctl.base.typed import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar
from teleopctl.interfaces.message import Message

if TYPE_CHECKING:
    from unique_identifier_msgs.msg import UUID

GoalT = TypeVar("GoalT", bound=Message)
ResultT = TypeVar("ResultT", bound=Message)
FeedbackT = TypeVar("FeedbackT", bound=Message)
Goal_co = TypeVar("Goal_co", bound=Message, covariant=True)
Result_co = TypeVar("Result_co", bound=Message, covariant=True)
Feedback_co = TypeVar("Feedback_co", bound=Message, covariant=True)
Request_co = TypeVar("Request_co", bound=Message, covariant=True)
Response_co = TypeVar("Response_co", bound=Message, covariant=True)


class ServiceType(Protocol[Request_co, Response_co]):
    """Interface of service classes, for ``create_client`` and ``create_service``."""

    TYPE_NAME: ClassVar[str]

    @property
    def Request(self) -> type[Request_co]:  # noqa: N802 (the name of the nested class)
        """Class of the request."""

    @property
    def Response(self) -> type[Response_co]:  # noqa: N802 (the name of the nested class)
        """Class of the response."""


class ActionType(Protocol[Goal_co, Result_co, Feedback_co]):
    """Interface of action classes, for action clients and servers."""

    TYPE_NAME: ClassVar[str]

    # Any: each action has its own class.
    @property
    def Impl(self) -> Any:  # noqa: N802 (the name of the nested class)
        """Classes of the action's messages and services on the wire."""

    @property
    def Goal(self) -> type[Goal_co]:  # noqa: N802 (the name of the nested class)
        """Class of the goal."""

    @property
    def Result(self) -> type[Result_co]:  # noqa: N802 (the name of the nested class)
        """Class of the result."""

    @property
    def Feedback(self) -> type[Feedback_co]:  # noqa: N802 (the name of the nested class)
        """Class of the feedback."""


class ResultResponse(Protocol[Result_co]):
    """Response to a result request of an action."""

    status: int

    @property
    def result(self) -> Result_co:
        """Result of the goal; the default if there is none."""


class FeedbackMessage(Protocol[Feedback_co]):
    """Feedback message of an action."""

    goal_id: UUID

    @property
    def feedback(self) -> Feedback_co:
        """Feedback about the goal."""


class Strings(Protocol):
    """List, tuple or set of strings, but not a single string.

    A single string is a sequence of strings too, but its ``__contains__`` accepts only strings,
    while that of other collections accepts any object.
    """

    def __contains__(self, value: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
