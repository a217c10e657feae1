"""What type checkers know of interface classes; imported for annotations only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Protocol, TypeVar

from teleopctl.interfaces.message import Message

Request_co = TypeVar("Request_co", bound=Message, covariant=True)
Response_co = TypeVar("Response_co", bound=Message, covariant=True)


class ServiceType(Protocol[Request_co, Response_co]):
    """A service class: what ``create_client`` and ``create_service`` take as ``type[...]``."""

    TYPE_NAME: ClassVar[str]

    @property
    def Request(self) -> type[Request_co]:  # noqa: N802 (the name of the nested class)
        """The class of the request."""

    @property
    def Response(self) -> type[Response_co]:  # noqa: N802 (the name of the nested class)
        """The class of the response."""


class Strings(Protocol):
    """Several strings: a list, a tuple, a set or the like, but not a string itself.

    A single string is a sequence of strings too; what tells it apart is that it asks for a string
    where other collections can be asked whether they contain anything.
    """

    def __contains__(self, value: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
