"""Types that ROS 2 derives from the definition of a service or an action."""

from __future__ import annotations

from teleopctl.interfaces.definition import Definition, Field, FieldType, Shape
from teleopctl.interfaces.parser import parse, split_at_dashes, split_sections
from teleopctl.interfaces.typenames import split

_UUID = Field("goal_id", FieldType("unique_identifier_msgs/msg/UUID"))
_TIME = FieldType("builtin_interfaces/msg/Time")
_EVENT_INFO = FieldType("service_msgs/msg/ServiceEventInfo")

SERVICE_PARTS = ("Request", "Response", "Event")
ACTION_PARTS = ("Goal", "Result", "Feedback", "FeedbackMessage")
ACTION_SERVICES = ("SendGoal", "GetResult")


def split_definition(text: str, type_name: str, where: str | None = None) -> list[Definition]:
    """Return the definitions in a ``.msg``, ``.srv`` or ``.action`` text, with derived types.

    Args:
        text: Content of the ``.msg``, ``.srv`` or ``.action`` file.
        type_name: Full name, ``package/kind/Name``; the kind determines the syntax of the text.
        where: Name of the text in error messages; the type's name by default.

    Returns:
        Definitions of the parts and derived types, and the definition of the type itself last.

    Raises:
        TeleopctlError: The text cannot be parsed.
    """
    package, kind, _ = split(type_name)
    place = where or type_name
    parts = split_sections(text, kind, place)
    if kind == "msg":
        return [parse(text, type_name, package, place)]
    suffixes = SERVICE_PARTS if kind == "srv" else ACTION_PARTS
    parsed = [
        parse(part, f"{type_name}_{suffix}", package, place, first_line)
        for (part, first_line), suffix in zip(parts, suffixes, strict=False)
    ]
    if kind == "srv":
        return [*parsed, *service_types(type_name, text)]
    return [*parsed, *action_types(type_name, text)]


def service_of_event(type_name: str, text: str) -> str | None:
    """Return the service's name if an event type's text defines the whole service, else None.

    rosbag2 writes the ``.srv`` file of a service as the definition of its events.

    Args:
        type_name: Full name of the type, ``package/srv/Name_Event`` for an event type.
        text: Definition text of the type.
    """
    service = type_name.removesuffix("_Event")
    is_event = service != type_name and split(type_name)[1] == "srv"
    return service if is_event and len(split_at_dashes(text)) > 1 else None


def service_types(name: str, text: str | None = None) -> list[Definition]:
    """Return the definitions of a service's event type and of the service type itself.

    The definitions of request and response are not included.

    Args:
        name: Full name of the service, ``package/srv/Name``.
        text: Content of the ``.srv`` file, kept in the service's definition.
    """
    request, response = FieldType(f"{name}_Request"), FieldType(f"{name}_Response")
    event = Definition(
        f"{name}_Event",
        (
            Field("info", _EVENT_INFO),
            Field("request", FieldType(request.base, Shape.BOUNDED, 1)),
            Field("response", FieldType(response.base, Shape.BOUNDED, 1)),
        ),
    )
    service = Definition(
        name,
        (
            Field("request_message", request),
            Field("response_message", response),
            Field("event_message", FieldType(event.type_name)),
        ),
        text=text,
    )
    return [event, service]


def action_types(name: str, text: str) -> list[Definition]:
    """Return the definitions of an action type and its derived types, such as SendGoal.

    The definitions of goal, result and feedback are not included.

    Args:
        name: Full name of the action, ``package/action/Name``.
        text: Content of the ``.action`` file, kept in the action's definition.
    """
    goal, result, feedback = (FieldType(f"{name}_{part}") for part in ACTION_PARTS[:3])
    send_goal, get_result = (f"{name}_{part}" for part in ACTION_SERVICES)
    feedback_message = Definition(f"{name}_FeedbackMessage", (_UUID, Field("feedback", feedback)))
    return [
        Definition(f"{send_goal}_Request", (_UUID, Field("goal", goal))),
        Definition(
            f"{send_goal}_Response",
            (Field("accepted", FieldType("bool")), Field("stamp", _TIME)),
        ),
        *service_types(send_goal),
        Definition(f"{get_result}_Request", (_UUID,)),
        Definition(
            f"{get_result}_Response",
            (Field("status", FieldType("int8")), Field("result", result)),
        ),
        *service_types(get_result),
        feedback_message,
        Definition(
            name,
            (
                Field("goal", goal),
                Field("result", result),
                Field("feedback", feedback),
                Field("send_goal_service", FieldType(send_goal)),
                Field("get_result_service", FieldType(get_result)),
                Field("feedback_message", FieldType(feedback_message.type_name)),
            ),
            text=text,
        ),
    ]
