"""The service ``~/get_type_description``: a tool that lacks a type asks who uses it (REP 2016)."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.errors import InvalidTypeNameError, TeleopctlError
from teleopctl.interfaces import (
    definition_text,
    get_message,
    get_service,
    type_description,
    type_hash,
)
from teleopctl.node.values.qos import qos_profile_services_default

if TYPE_CHECKING:
    from teleopctl.node.node_parameters import NodeParameters

_PARAMETER = "start_type_description_service"


def start_type_description_service(node: NodeParameters) -> None:
    """Start the ~/get_type_description service, unless its parameter disables it."""
    descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(
        description="Start the ~/get_type_description service for this node.", read_only=True
    )
    if not node.declare_parameter(_PARAMETER, True, descriptor).value:
        return
    node.create_service(
        get_service("type_description_interfaces/srv/GetTypeDescription"),
        "~/get_type_description",
        _answer,
        qos_profile=qos_profile_services_default,
    )


def _answer(request: Any, response: Any) -> Any:
    try:
        actual = type_hash(request.type_name)
        if request.type_hash not in ("", actual):
            raise InvalidTypeNameError(
                f"type '{request.type_name}' has the hash {actual} here, not {request.type_hash}"
            )
        response.type_description = _to_message(type_description(request.type_name))
        if request.include_type_sources:
            source = get_message("type_description_interfaces/msg/TypeSource")
            response.type_sources = [
                source(
                    type_name=request.type_name,
                    encoding=request.type_name.split("/")[1],
                    raw_file_contents=definition_text(request.type_name),
                )
            ]
        response.successful = True
    except TeleopctlError as error:
        response.successful = False
        response.failure_reason = error.message
    return response


def _to_message(description: dict[str, Any]) -> Any:
    """Return the message form of the JSON structure that a type hash is taken of."""
    return get_message("type_description_interfaces/msg/TypeDescription")(
        type_description=_individual(description["type_description"]),
        referenced_type_descriptions=[
            _individual(entry) for entry in description["referenced_type_descriptions"]
        ],
    )


def _individual(entry: dict[str, Any]) -> Any:
    package = "type_description_interfaces/msg"
    field_type = get_message(f"{package}/FieldType")
    field = get_message(f"{package}/Field")
    return get_message(f"{package}/IndividualTypeDescription")(
        type_name=entry["type_name"],
        fields=[
            field(name=item["name"], type=field_type(**item["type"])) for item in entry["fields"]
        ],
    )
