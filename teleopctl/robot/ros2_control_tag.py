"""``<ros2_control>``: hardware of a robot with its command and state interfaces.

Error messages are ros2_control's, so that a web search for them finds its answers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple, cast, get_args

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, boolean, child_text, required, to_number
from teleopctl.robot.joint_rules import (
    LIMITED_INTERFACES,
    UNLIMITED,
    Bounds,
    JointLimits,
    joint_limits,
    mimic_in_control,
    resolve_mimics,
)
from teleopctl.robot.urdf import Joint, Mimic

ComponentType = Literal["system", "actuator", "sensor"]

_TYPES = ("double", "bool", "float32", "uint8", "int8", "uint16", "int16", "uint32", "int32")
_CHILDREN = ("hardware", "joint", "sensor", "gpio", "transmission", "properties")


@dataclass(frozen=True, slots=True)
class InterfaceInfo:
    """``<command_interface>`` or ``<state_interface>`` of a ``<ros2_control>`` tag.

    Attributes:
        name: Name within the component, for example ``position``.
        data_type: Name of the data type; ``unknown`` for a type that ros2_control lacks.
        size: Number of values.
        min: ``min`` as written, or an empty string.
        max: ``max`` as written, or an empty string.
        initial_value: Value until the hardware writes another one, or None.
        parameters: Every ``<param>``, including those above.
        enable_limits: False where the tag disables the limits of this interface.
        line: Line of the tag; 0 if unknown.
    """

    name: str
    data_type: str
    size: int
    min: str
    max: str
    initial_value: float | None
    parameters: Mapping[str, str]
    enable_limits: bool
    line: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class ComponentInfo:
    """``<joint>``, ``<sensor>`` or ``<gpio>`` of a ``<ros2_control>`` tag.

    Attributes:
        name: Name of the joint, sensor or GPIO.
        type: Kind of the tag.
        command_interfaces: Interfaces that can be commanded.
        state_interfaces: Interfaces that can be read.
        parameters: Values of ``<param>`` by name.
        leaders: Joints that a joint mimics in control, the nearest first, from the URDF or from
            ``<ros2_control>``; see `joint_rules.resolve_mimics`.
        limits: Limits of a joint's commands.
    """

    name: str
    type: Literal["joint", "sensor", "gpio"]
    command_interfaces: tuple[InterfaceInfo, ...]
    state_interfaces: tuple[InterfaceInfo, ...]
    parameters: Mapping[str, str]
    leaders: tuple[Mimic, ...] = ()
    limits: JointLimits = UNLIMITED

    @property
    def mimic(self) -> Mimic | None:
        """Mimic relation to the independent joint at the end of the chain of leaders, or None."""
        return self.leaders[-1] if self.leaders else None


@dataclass(frozen=True, slots=True)
class TransmissionEnd:
    """Joint or actuator of a ``<transmission>``, with its reduction and offset."""

    name: str
    role: str
    mechanical_reduction: float = 1.0
    offset: float = 0.0
    read_only: bool = False


@dataclass(frozen=True, slots=True)
class TransmissionInfo:
    """``<transmission>`` of a ``<ros2_control>`` tag, between actuators and joints.

    ``line`` is the line of the tag; 0 if unknown.
    """

    name: str
    type: str
    joints: tuple[TransmissionEnd, ...]
    actuators: tuple[TransmissionEnd, ...]
    parameters: Mapping[str, str]
    line: int = field(default=0, compare=False)


class AsyncThread(NamedTuple):
    """Scheduling of the thread of an asynchronous hardware component or controller.

    Attributes:
        priority: Real-time priority.
        affinity: Numbers of the processors that the thread may use; empty for all.
        is_detached: Whether the thread keeps its rate by itself, without triggers of the manager.
        print_warnings: Whether triggers that are missed are logged.
    """

    priority: int = 50
    affinity: tuple[int, ...] = ()
    is_detached: bool = False
    print_warnings: bool = True


@dataclass(frozen=True, slots=True)
class HardwareInfo:
    """``<ros2_control>`` tag: hardware plug-in, parameters, joints, sensors and gpios.

    Attributes:
        name: Name of the hardware component.
        type: Type of the component: ``system``, ``actuator`` or ``sensor``.
        hardware_plugin_name: Name of the hardware's class.
        group: Group of components that fail together, or an empty string.
        hardware_parameters: ``<param>`` of ``<hardware>``.
        rw_rate: Rate of reads and writes in Hz; 0 for the controller manager's rate.
        is_async: Whether the component runs in a thread of its own.
        async_thread: Scheduling of that thread.
        joints: Joints, in the order of the tag.
        sensors: Sensors.
        gpios: General-purpose inputs and outputs.
        transmissions: Transmissions.
        warnings: Sentences about parts of the tag that are ignored or read differently.
    """

    name: str
    type: ComponentType
    hardware_plugin_name: str
    group: str
    hardware_parameters: Mapping[str, str]
    rw_rate: int
    is_async: bool
    async_thread: AsyncThread
    joints: tuple[ComponentInfo, ...]
    sensors: tuple[ComponentInfo, ...]
    gpios: tuple[ComponentInfo, ...]
    transmissions: tuple[TransmissionInfo, ...]
    warnings: tuple[str, ...] = ()


def read_components(robot: XmlElement, joints: Mapping[str, Joint]) -> tuple[HardwareInfo, ...]:
    """Return the hardware of every ``<ros2_control>`` tag in a ``<robot>`` element.

    Args:
        robot: Root element of the URDF.
        joints: Joints of the URDF by name.

    Raises:
        InvalidDescriptionError: When a tag breaks the grammar or contradicts the URDF.
    """
    components: dict[str, HardwareInfo] = {}
    for element in robot.findall("ros2_control"):
        component = _read_component(element, joints)
        if component.name in components:
            raise InvalidDescriptionError(f"Component name '{component.name}' is not unique")
        components[component.name] = component
    return tuple(components.values())


def _read_component(element: XmlElement, urdf_joints: Mapping[str, Joint]) -> HardwareInfo:
    name, kind = required(element, "name"), required(element, "type")
    if kind not in get_args(ComponentType):
        raise InvalidDescriptionError(
            f"Component '{name}' is of unknown type '{kind}'",
            hint=f"Known are {', '.join(get_args(ComponentType))}.",
        )
    for child in element:
        if child.tag not in _CHILDREN:
            raise InvalidDescriptionError(
                f"invalid tag name '{child.tag}'",
                hint=f'<ros2_control name="{name}"> may hold {", ".join(_CHILDREN)}.',
            )
    hardware = element.find("hardware")
    plugin = "" if hardware is None else child_text(hardware, "plugin")
    if hardware is None or not plugin:
        raise InvalidDescriptionError(
            f"Missing <plugin> tag of <hardware> element for '{name}' in your URDF."
        )
    warnings: list[str] = []
    joints = _read_joints(element.findall("joint"), urdf_joints, warnings)
    transmissions = _read_transmissions(element, name)
    if kind == "actuator" and any(len(found.joints) != 1 for found in transmissions):
        raise InvalidDescriptionError(
            f"Actuator '{name}': a transmission of an actuator names exactly one joint"
        )
    is_async = _flag(element, "is_async", default=False)
    return HardwareInfo(
        name=name,
        type=cast(ComponentType, kind),
        hardware_plugin_name=plugin,
        group=child_text(hardware, "group"),
        hardware_parameters=_parameters(hardware),
        rw_rate=_integer(element, "rw_rate", 0, least=0),
        is_async=is_async,
        async_thread=_async_thread(element, name) if is_async else AsyncThread(),
        joints=joints,
        sensors=tuple(_read_part(child, "sensor") for child in element.findall("sensor")),
        gpios=tuple(_read_part(child, "gpio") for child in element.findall("gpio")),
        transmissions=transmissions,
        warnings=tuple(warnings),
    )


def _read_part(element: XmlElement, kind: Literal["joint", "sensor", "gpio"]) -> ComponentInfo:
    return ComponentInfo(
        name=required(element, "name"),
        type=kind,
        command_interfaces=tuple(
            _read_interface(child) for child in element.findall("command_interface")
        ),
        state_interfaces=tuple(
            _read_interface(child) for child in element.findall("state_interface")
        ),
        parameters=_parameters(element),
    )


def _read_joints(
    elements: Sequence[XmlElement], urdf_joints: Mapping[str, Joint], warnings: list[str]
) -> tuple[ComponentInfo, ...]:
    in_tag = {required(element, "name"): element for element in elements}
    parts: dict[str, ComponentInfo] = {}
    mimics: dict[str, Mimic] = {}
    for name, element in in_tag.items():
        part = _read_part(element, "joint")
        joint = urdf_joints.get(name)
        if joint is None:
            # Fans and the like, which ROS 2 accepted until Humble.
            warnings.append(
                f"Joint '{name}' of <ros2_control> is left out: the robot has none of that name, "
                "and ROS 2 refuses it since Jazzy"
            )
            continue
        if joint.type == "fixed":
            raise InvalidDescriptionError(
                f"Joint '{name}' is of type 'fixed'. "
                "Fixed joints do not make sense in ros2_control."
            )
        attribute = element.get("mimic")
        enabled = None if attribute is None else boolean(attribute, f"mimic of joint '{name}'")
        mimic = mimic_in_control(joint, enabled, part.parameters, warnings)
        if mimic is not None:
            if mimic.joint not in in_tag:
                raise InvalidDescriptionError(
                    f"Mimic joint '{mimic.joint}' not found in <ros2_control> tag"
                )
            mimics[name] = mimic
            part = _without_commands(part, joint, warnings)
        limits = _read_limits(element, part, joint, warnings)
        parts[name] = replace(part, limits=limits)
    leaders = resolve_mimics(in_tag, mimics)
    return tuple(replace(part, leaders=leaders.get(name, ())) for name, part in parts.items())


def _without_commands(part: ComponentInfo, joint: Joint, warnings: list[str]) -> ComponentInfo:
    """Return a mimic joint without its command interfaces; warn about each removed one.

    Raises:
        InvalidDescriptionError: When the joint has command interfaces and its mimic relation is
            from the URDF, as in ROS 2. The older form, with parameters, allows the interfaces.
    """
    if not part.command_interfaces:
        return part
    if "mimic" not in part.parameters:
        raise InvalidDescriptionError(
            f"Joint '{joint.name}' has mimic attribute not set to false: "
            "Activated mimic joints cannot have command interfaces."
        )
    names = ", ".join(f"{joint.name}/{interface.name}" for interface in part.command_interfaces)
    warnings.append(f"Joint '{joint.name}' follows another joint and cannot be commanded: {names}")
    return replace(part, command_interfaces=())


def _read_limits(
    element: XmlElement, part: ComponentInfo, joint: Joint, warnings: list[str]
) -> JointLimits:
    if not _limits_enabled(element):
        return replace(UNLIMITED, enabled=False)
    bounds = {
        interface.name: _bounds(joint.name, interface, warnings)
        if interface.enable_limits
        else None
        for interface in part.command_interfaces
    }
    return joint_limits(joint, bounds, warnings)


def _bounds(joint: str, interface: InterfaceInfo, warnings: list[str]) -> Bounds:
    if interface.name not in LIMITED_INTERFACES:
        if interface.min or interface.max:
            warnings.append(
                f"Limits of '{joint}/{interface.name}' are ignored: "
                f"only {', '.join(LIMITED_INTERFACES)} can be limited"
            )
        return Bounds()
    values = []
    for label, text in (("min", interface.min), ("max", interface.max)):
        value = to_number(text) if text else None
        if text and value is None:
            warnings.append(
                f"The {label} of '{joint}/{interface.name}' should be a number, got '{text}': "
                "it is ignored"
            )
        values.append(value)
    return Bounds(values[0], values[1], interface.line)


def _limits_enabled(element: XmlElement) -> bool:
    limits = element.find("limits")
    return limits is None or _required_flag(limits, "enable")


def _required_flag(element: XmlElement, attribute: str) -> bool:
    return boolean(required(element, attribute), f"attribute '{attribute}' of <{element.tag}>")


def _read_interface(element: XmlElement) -> InterfaceInfo:
    parameters = _parameters(element)
    data_type = element.get("data_type") or "double"
    return InterfaceInfo(
        name=required(element, "name"),
        data_type=data_type if data_type in _TYPES else "unknown",
        size=_integer(element, "size", 1, least=1),
        min=parameters.get("min", ""),
        max=parameters.get("max", ""),
        initial_value=_initial_value(parameters.get("initial_value", ""), data_type),
        parameters=parameters,
        enable_limits=_limits_enabled(element),
        line=element.sourceline or 0,
    )


def _initial_value(text: str, data_type: str) -> float | None:
    """Return an interface's value at start, 0 or 1 for a boolean; None if none is given."""
    if data_type != "bool":
        return to_number(text)
    return float(boolean(text, "initial_value of an interface of type bool")) if text else 0.0


def _read_transmissions(component: XmlElement, name: str) -> tuple[TransmissionInfo, ...]:
    """Return a component's transmissions; that of an actuator component has an ``actuator1``."""
    joints = {joint.get("name") for joint in component.findall("joint")}
    found = []
    for element in component.findall("transmission"):
        one = _read_transmission(element)
        for end in one.joints:
            if end.name not in joints:
                raise InvalidDescriptionError(
                    f"Error while parsing '{name}'. Transmission '{one.name}' declared joint "
                    f"'{end.name}' is not available in component '{name}'."
                )
        if component.get("type") == "actuator" and not one.actuators:
            one = replace(one, actuators=(TransmissionEnd("actuator1", "actuator1"),))
        found.append(one)
    return tuple(found)


def _read_transmission(element: XmlElement) -> TransmissionInfo:
    name = required(element, "name")
    plugin = child_text(element, "plugin")
    if not plugin:
        raise InvalidDescriptionError(f"Missing <plugin> tag in transmission '{name}'")
    joints = tuple(_read_end(child) for child in element.findall("joint"))
    if not joints:
        raise InvalidDescriptionError(f"Transmission '{name}' has no <joint>")
    return TransmissionInfo(
        name=name,
        type=plugin,
        joints=joints,
        actuators=tuple(_read_end(child) for child in element.findall("actuator")),
        parameters=_parameters(element),
        line=element.sourceline or 0,
    )


def _read_end(element: XmlElement) -> TransmissionEnd:
    return TransmissionEnd(
        name=required(element, "name"),
        role=required(element, "role"),
        mechanical_reduction=_child_number(element, "mechanical_reduction", "1"),
        offset=_child_number(element, "offset", "0"),
        read_only=_flag(element, "read_only", default=False),
    )


def _child_number(element: XmlElement, tag: str, default: str) -> float:
    text = child_text(element, tag, default)
    value = to_number(text)
    if value is None:
        name = element.get("name")
        raise InvalidDescriptionError(f"<{tag}> of '{name}' should be a number, got '{text}'")
    return value


def _parameters(element: XmlElement) -> dict[str, str]:
    return {
        required(child, "name"): (child.text or "").strip() for child in element.findall("param")
    }


def _flag(element: XmlElement, attribute: str, *, default: bool) -> bool:
    text = element.get(attribute)
    return default if text is None else boolean(text, f"attribute '{attribute}'")


def _integer(element: XmlElement, attribute: str, default: int, *, least: int) -> int:
    text = element.get(attribute)
    if text is None:
        return default
    value = int(text) if text.isascii() and text.isdigit() else -1
    if not least <= value < 2**31:
        expected = "a non-zero positive integer" if least else "an integer that is not negative"
        raise InvalidDescriptionError(
            f'Could not parse {attribute} tag in "{element.get("name")}". '
            f'Got "{text}", but expected {expected}.'
        )
    return value


def _async_thread(element: XmlElement, name: str) -> AsyncThread:
    """Return the thread of ``<properties><async/></properties>``; the priority also of the tag.

    Raises:
        InvalidDescriptionError: An attribute has an invalid value.
    """
    properties = element.find("properties")
    tag = None if properties is None else properties.find("async")
    priority = _integer(element, "thread_priority", AsyncThread().priority, least=1)
    if tag is None:
        return AsyncThread(priority)
    policy = (tag.get("scheduling_policy") or "synchronized").strip()
    if policy not in ("synchronized", "detached"):
        raise InvalidDescriptionError(
            f"scheduling_policy of <async> in '{name}' should be synchronized or detached, got "
            f"'{policy}'"
        )
    affinity = (tag.get("affinity") or "").strip().removeprefix("[").removesuffix("]")
    processors = [number.strip() for number in affinity.split(",") if number.strip()]
    if not all(number.isascii() and number.isdigit() for number in processors):
        raise InvalidDescriptionError(
            f"affinity of <async> in '{name}' should be numbers of processors such as [2, 4], got "
            f"'{tag.get('affinity')}'"
        )
    return AsyncThread(
        _integer(tag, "thread_priority", priority, least=1),
        tuple(int(number) for number in processors),
        policy == "detached",
        _flag(tag, "print_warnings", default=True),
    )
