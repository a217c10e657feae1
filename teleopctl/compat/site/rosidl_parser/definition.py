"""``rosidl_parser.definition``. Types of fields (``SLOT_TYPES``), and IDL files as values."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from teleopctl.interfaces import (
    AbstractGenericString,
    AbstractNestableType,
    AbstractNestedType,
    AbstractSequence,
    AbstractString,
    AbstractType,
    AbstractWString,
    Array,
    BasicType,
    BoundedSequence,
    BoundedString,
    BoundedWString,
    NamespacedType,
    UnboundedSequence,
    UnboundedString,
    UnboundedWString,
)

__all__ = [
    "AbstractGenericString",
    "AbstractNestableType",
    "AbstractNestedType",
    "AbstractSequence",
    "AbstractString",
    "AbstractType",
    "AbstractWString",
    "Action",
    "Annotatable",
    "Annotation",
    "Array",
    "BasicType",
    "BoundedSequence",
    "BoundedString",
    "BoundedWString",
    "Constant",
    "IdlContent",
    "IdlFile",
    "IdlLocator",
    "Include",
    "Member",
    "Message",
    "NamedType",
    "NamespacedType",
    "Service",
    "Structure",
    "UnboundedSequence",
    "UnboundedString",
    "UnboundedWString",
]

# Names of basic types in IDL.
SIGNED_NONEXPLICIT_INTEGER_TYPES = ("short", "long", "long long")
UNSIGNED_NONEXPLICIT_INTEGER_TYPES = tuple(
    f"unsigned {t}" for t in SIGNED_NONEXPLICIT_INTEGER_TYPES
)
NONEXPLICIT_INTEGER_TYPES = SIGNED_NONEXPLICIT_INTEGER_TYPES + UNSIGNED_NONEXPLICIT_INTEGER_TYPES
SIGNED_EXPLICIT_INTEGER_TYPES = ("int8", "int16", "int32", "int64")
UNSIGNED_EXPLICIT_INTEGER_TYPES = ("uint8", "uint16", "uint32", "uint64")
EXPLICIT_INTEGER_TYPES = SIGNED_EXPLICIT_INTEGER_TYPES + UNSIGNED_EXPLICIT_INTEGER_TYPES
SIGNED_INTEGER_TYPES = SIGNED_NONEXPLICIT_INTEGER_TYPES + SIGNED_EXPLICIT_INTEGER_TYPES
UNSIGNED_INTEGER_TYPES = UNSIGNED_NONEXPLICIT_INTEGER_TYPES + UNSIGNED_EXPLICIT_INTEGER_TYPES
INTEGER_TYPES = SIGNED_INTEGER_TYPES + UNSIGNED_INTEGER_TYPES
FLOATING_POINT_TYPES = ("float", "double", "long double")
CHARACTER_TYPES = ("char", "wchar")
BOOLEAN_TYPE = "boolean"
OCTET_TYPE = "octet"
BASIC_TYPES = (*INTEGER_TYPES, *FLOATING_POINT_TYPES, *CHARACTER_TYPES, BOOLEAN_TYPE, OCTET_TYPE)

# What the names of the parts of definitions end with, and what an empty message has.
EMPTY_STRUCTURE_REQUIRED_MEMBER_NAME = "structure_needs_at_least_one_member"
CONSTANT_MODULE_SUFFIX = "_Constants"
SERVICE_REQUEST_MESSAGE_SUFFIX = "_Request"
SERVICE_RESPONSE_MESSAGE_SUFFIX = "_Response"
SERVICE_EVENT_MESSAGE_SUFFIX = "_Event"
ACTION_GOAL_SUFFIX = "_Goal"
ACTION_RESULT_SUFFIX = "_Result"
ACTION_FEEDBACK_SUFFIX = "_Feedback"
ACTION_GOAL_SERVICE_SUFFIX = "_SendGoal"
ACTION_RESULT_SERVICE_SUFFIX = "_GetResult"
ACTION_FEEDBACK_MESSAGE_SUFFIX = "_FeedbackMessage"


@dataclass(frozen=True)
class NamedType(AbstractNestableType):
    """A type by a name that is not resolved."""

    name: str


@dataclass(eq=False)
class Annotation:
    """Annotation ``@name(…)``: its value is None, one value, or several by name."""

    name: str
    value: object = None


class Annotatable:
    """Base class of elements with annotations."""

    annotations: list[Annotation]

    def get_annotation_values(self, name: str) -> list[object]:
        """Return the values of all annotations of a name."""
        return [one.value for one in self.annotations if one.name == name]

    def get_annotation_value(self, name: str) -> object:
        """Return the value of the one annotation of a name.

        Raises:
            ValueError: There is none, or more than one.
        """
        values = self.get_annotation_values(name)
        if len(values) != 1:
            raise ValueError(f"{'Multiple' if values else 'No'} '{name}' annotations")
        return values[0]

    def has_annotation(self, name: str) -> bool:
        """Return whether there is exactly one annotation of a name."""
        return len(self.get_annotation_values(name)) == 1

    def has_annotations(self, name: str) -> bool:
        """Return whether there is an annotation of a name."""
        return bool(self.get_annotation_values(name))

    def get_comment_lines(self) -> list[str]:
        """Return the lines of all comments."""
        return [
            line
            for value in self.get_annotation_values("verbatim")
            if isinstance(value, dict) and value.get("language") == "comment"
            for line in str(value.get("text", "")).splitlines()
        ]


@dataclass(eq=False)
class Member(Annotatable):
    """A member of a structure."""

    type: AbstractType
    name: str
    annotations: list[Annotation] = field(default_factory=list)


@dataclass(eq=False)
class Structure(Annotatable):
    """Members under a name."""

    namespaced_type: NamespacedType
    members: list[Member] = field(default_factory=list)
    annotations: list[Annotation] = field(default_factory=list)

    def has_any_member_with_annotation(self, name: str) -> bool:
        """Return whether a member has exactly one annotation of a name."""
        return any(member.has_annotation(name) for member in self.members)


@dataclass(eq=False)
class Include:
    """A file that is included."""

    locator: str


@dataclass(eq=False)
class Constant(Annotatable):
    """A constant."""

    name: str
    type: AbstractType
    value: str | int | float | bool
    annotations: list[Annotation] = field(default_factory=list)


@dataclass(eq=False)
class Message:
    """A structure with constants."""

    structure: Structure
    constants: list[Constant] = field(default_factory=list)


class Service:
    """Service: request, response and event, and the types derived from them."""

    def __init__(
        self, namespaced_type: NamespacedType, request: Message, response: Message
    ) -> None:
        self.namespaced_type = namespaced_type
        self.request_message = request
        self.response_message = response
        self.event_message = _made(
            namespaced_type,
            SERVICE_EVENT_MESSAGE_SUFFIX,
            info=NamespacedType(["service_msgs", "msg"], "ServiceEventInfo"),
            request=BoundedSequence(request.structure.namespaced_type, 1),
            response=BoundedSequence(response.structure.namespaced_type, 1),
        )


class Action:
    """Action: goal, result and feedback, and the types derived from them."""

    def __init__(
        self, namespaced_type: NamespacedType, goal: Message, result: Message, feedback: Message
    ) -> None:
        self.namespaced_type = namespaced_type
        self.goal = goal
        self.result = result
        self.feedback = feedback
        self.implicit_includes = [
            Include("builtin_interfaces/msg/Time.idl"),
            Include("unique_identifier_msgs/msg/UUID.idl"),
        ]
        goal_id = NamespacedType(["unique_identifier_msgs", "msg"], "UUID")
        send = _suffixed(namespaced_type, ACTION_GOAL_SERVICE_SUFFIX)
        self.send_goal_service = Service(
            send,
            _made(
                send,
                SERVICE_REQUEST_MESSAGE_SUFFIX,
                goal_id=goal_id,
                goal=goal.structure.namespaced_type,
            ),
            _made(
                send,
                SERVICE_RESPONSE_MESSAGE_SUFFIX,
                accepted=BasicType(BOOLEAN_TYPE),
                stamp=NamespacedType(["builtin_interfaces", "msg"], "Time"),
            ),
        )
        get = _suffixed(namespaced_type, ACTION_RESULT_SERVICE_SUFFIX)
        self.get_result_service = Service(
            get,
            _made(get, SERVICE_REQUEST_MESSAGE_SUFFIX, goal_id=goal_id),
            _made(
                get,
                SERVICE_RESPONSE_MESSAGE_SUFFIX,
                status=BasicType("int8"),
                result=result.structure.namespaced_type,
            ),
        )
        self.feedback_message = _made(
            namespaced_type,
            ACTION_FEEDBACK_MESSAGE_SUFFIX,
            goal_id=goal_id,
            feedback=feedback.structure.namespaced_type,
        )


def _suffixed(name: NamespacedType, suffix: str) -> NamespacedType:
    return NamespacedType(name.namespaces, name.name + suffix)


def _made(name: NamespacedType, suffix: str, **members: AbstractType) -> Message:
    parts = [Member(type_, member) for member, type_ in members.items()]
    return Message(Structure(_suffixed(name, suffix), parts))


class IdlLocator:
    """Path of an IDL file.

    Args:
        basepath: A folder.
        relative_path: The file below it.
    """

    def __init__(self, basepath: str | Path, relative_path: str | Path) -> None:
        self.basepath = Path(basepath)
        self.relative_path = Path(relative_path)

    def get_absolute_path(self) -> Path:
        """Return the path of the file."""
        return self.basepath / self.relative_path


ElementT = TypeVar("ElementT", Include, Message, Service, Action)


@dataclass(eq=False)
class IdlContent:
    """Content of an IDL file: includes, and a message, a service or an action."""

    elements: list[Include | Message | Service | Action] = field(default_factory=list)

    def get_elements_of_type(self, type_: type[ElementT]) -> list[ElementT]:
        """Return the elements of a class."""
        return [one for one in self.elements if isinstance(one, type_)]


@dataclass(eq=False)
class IdlFile:
    """A file and its content."""

    locator: IdlLocator
    content: IdlContent
