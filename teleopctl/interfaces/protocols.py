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
    """Typing protocol of service classes, which have a ``Request`` and a ``Response``."""

    TYPE_NAME: ClassVar[str]

    @property
    def Request(self) -> type[Request_co]:  # noqa: N802 (the name of the nested class)
        """Message class of the service's requests."""

    @property
    def Response(self) -> type[Response_co]:  # noqa: N802 (the name of the nested class)
        """Message class of the service's responses."""


class ActionType(Protocol[Goal_co, Result_co, Feedback_co]):
    """Typing protocol of action classes, for action clients and servers."""

    TYPE_NAME: ClassVar[str]

    # Any: each action has its own class.
    @property
    def Impl(self) -> Any:  # noqa: N802 (the name of the nested class)
        """Namespace of the classes of the action's services and messages on the wire."""

    @property
    def Goal(self) -> type[Goal_co]:  # noqa: N802 (the name of the nested class)
        """Message class of the action's goals."""

    @property
    def Result(self) -> type[Result_co]:  # noqa: N802 (the name of the nested class)
        """Message class of the action's results."""

    @property
    def Feedback(self) -> type[Feedback_co]:  # noqa: N802 (the name of the nested class)
        """Message class of the action's feedback."""


class ResultResponse(Protocol[Result_co]):
    """Typing protocol of the response to an action's result request: status and result."""

    status: int

    @property
    def result(self) -> Result_co:
        """Result message of the goal; a default message if the goal has no result."""


class FeedbackMessage(Protocol[Feedback_co]):
    """Typing protocol of an action's feedback message on the wire: goal ID and feedback."""

    goal_id: UUID

    @property
    def feedback(self) -> Feedback_co:
        """Feedback about the goal, of the class ``Feedback`` of the action."""


class Strings(Protocol):
    """Typing protocol of lists, tuples and sets of strings; excludes a single string.

    A single string is a sequence of strings too, but its ``__contains__`` accepts only strings,
    while that of other collections accepts any object.
    """

    def __contains__(self, value: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
