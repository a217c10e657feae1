"""Sensor type ``contact``: contact points, normals and forces of a link."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.interfaces import get_message
from teleopctl.robot import SensorTag as Description
from teleopctl.sim.sensors.base import Sensor

Array = npt.NDArray[np.float64]

_CLASSIC, _GZ = "gazebo_msgs/msg/ContactsState", "ros_gz_interfaces/msg/Contacts"
_COLLISION = 5  # ros_gz_interfaces/Entity
# Gazebo's names of collision shapes in a URDF, also of links that it has lumped into their parent.
_LUMPED = re.compile(r".*_fixed_joint_lump__")
# Names that unnamed shapes of worlds get here.
_MADE_UP = re.compile(r"(.*/)?shape\d+")
_NUMBERED = re.compile(r"_collision(_\d+)?$")


class _Touch(NamedTuple):
    """Contact point of two shapes; ``force`` and ``torque`` act on the first, at ``position``."""

    position: Array
    normal: Array
    depth: float
    force: Array
    torque: Array


class Contact(Sensor):
    """Contact sensor of a link's collision shapes, in the world's axes.

    The message is a gazebo_msgs/ContactsState with Gazebo classic's bumper plug-in, else a
    ros_gz_interfaces/Contacts. The first shape of a pair is one of the link; forces act on this
    shape, and the normal points into it. The list is empty if the link touches nothing.
    """

    plugin_topic = "bumper_states"

    def __init__(self, description: Description) -> None:
        super().__init__(description)
        classic = "gazebo_ros_bumper" in self.names.plugin_file
        self.message_type = _CLASSIC if classic else _GZ
        self._links: tuple[str, ...] = ()

    @property
    def frame_id(self) -> str:
        """Frame of the contacts: ``world``, unless the plug-in sets another."""
        return self.names.setting("frame_name", "frameName") or "world"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Look up the links whose collision shapes the sensor reports; nothing is added."""
        if spec.body(self.description.link) is None:
            raise InvalidDescriptionError(f"the robot has no link '{self.description.link}'")
        named = [
            _NUMBERED.sub("", _LUMPED.sub("", shape)) for shape in self.description.contact if shape
        ]
        found = [link for link in dict.fromkeys(named) if spec.body(link) is not None]
        self._links = tuple(found) or (self.description.link,)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill the message with the contacts of the links' shapes, one entry per pair of shapes."""
        pairs: dict[tuple[int, int], list[_Touch]] = {}
        for own, other, touch in _touches(model, data, self._own_bodies(model)):
            pairs.setdefault((own, other), []).append(touch)
        fill = _classic_state if self.message_type == _CLASSIC else _gz_contact
        states = [
            fill(_name(model, own), _name(model, other), own, other, touches)
            for (own, other), touches in pairs.items()
        ]
        if self.message_type == _CLASSIC:
            message.states = states
        else:
            message.contacts = states
            for contact in states:
                for wrench in contact.wrenches:
                    wrench.header = message.header

    def _own_bodies(self, model: mujoco.MjModel) -> Collection[int]:
        """Return the indices of the bodies whose contacts are listed."""
        return {model.body(link).id for link in self._links}


class SceneContacts(Contact):
    """Sensor of all contacts in the world, on ``/mujoco_sim/contacts``.

    Args:
        rate_hz: Rate of the messages, in Hz of simulated time.
    """

    topic = "/mujoco_sim/contacts"
    is_state = True

    def __init__(self, rate_hz: float) -> None:
        super().__init__(
            Description(name="contacts", type="contact", link="world", update_rate=rate_hz)
        )

    def _own_bodies(self, model: mujoco.MjModel) -> Collection[int]:
        return range(model.nbody)


def _touches(
    model: mujoco.MjModel, data: mujoco.MjData, own_bodies: Collection[int]
) -> Iterator[tuple[int, int, _Touch]]:
    for number in range(data.ncon):
        contact = data.contact[number]
        one, two = (int(geom) for geom in contact.geom)
        if one < 0 or two < 0 or contact.exclude:
            continue
        first = int(model.geom_bodyid[one]) in own_bodies
        if not first and int(model.geom_bodyid[two]) not in own_bodies:
            continue
        # MuJoCo's normal points from the first to the second, and its force acts on the second.
        sign = -1.0 if first else 1.0
        wrench = np.zeros(6)
        mujoco.mj_contactForce(model, data, number, wrench)
        axes = np.array(contact.frame).reshape(3, 3)
        touch = _Touch(
            np.array(contact.pos),
            sign * axes[0],
            max(0.0, -float(contact.dist)),
            sign * (axes.T @ wrench[:3]),
            sign * (axes.T @ wrench[3:]),
        )
        yield (one, two, touch) if first else (two, one, touch)


def _name(model: mujoco.MjModel, geom: int) -> str:
    """Return a shape's name, or the one that Gazebo would give to an unnamed shape."""
    body = int(model.geom_bodyid[geom])
    own = model.geom(geom).name
    if own and not _MADE_UP.fullmatch(own):
        return str(own)
    first = int(model.body_geomadr[body])
    number = int(
        np.count_nonzero(model.geom_contype[first:geom] | model.geom_conaffinity[first:geom])
    )
    return f"{model.body(body).name}_collision" + (f"_{number}" if number else "")


# Any, here and below: classes that are made from their definitions.
def _vector(values: Array) -> Any:
    x, y, z = map(float, values)
    return get_message("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)


def _wrench(force: Array, torque: Array) -> Any:
    return get_message("geometry_msgs/msg/Wrench")(force=_vector(force), torque=_vector(torque))


def _classic_state(own: str, other: str, _one: int, _two: int, touches: list[_Touch]) -> Any:
    return get_message("gazebo_msgs/msg/ContactState")(
        info=f"{own} touches {other}",
        collision1_name=own,
        collision2_name=other,
        wrenches=[_wrench(touch.force, touch.torque) for touch in touches],
        total_wrench=_wrench(
            np.sum([touch.force for touch in touches], axis=0),
            np.sum([touch.torque for touch in touches], axis=0),
        ),
        contact_positions=[_vector(touch.position) for touch in touches],
        contact_normals=[_vector(touch.normal) for touch in touches],
        depths=[touch.depth for touch in touches],
    )


def _gz_contact(own: str, other: str, one: int, two: int, touches: list[_Touch]) -> Any:
    entity = get_message("ros_gz_interfaces/msg/Entity")
    text = get_message("std_msgs/msg/String")
    number = get_message("std_msgs/msg/UInt32")
    joint_wrench = get_message("ros_gz_interfaces/msg/JointWrench")
    return get_message("ros_gz_interfaces/msg/Contact")(
        collision1=entity(id=one, name=own, type=_COLLISION),
        collision2=entity(id=two, name=other, type=_COLLISION),
        positions=[_vector(touch.position) for touch in touches],
        normals=[_vector(touch.normal) for touch in touches],
        depths=[touch.depth for touch in touches],
        wrenches=[
            joint_wrench(
                body_1_name=text(data=own),
                body_1_id=number(data=one),
                body_2_name=text(data=other),
                body_2_id=number(data=two),
                body_1_wrench=_wrench(touch.force, touch.torque),
                body_2_wrench=_wrench(-touch.force, -touch.torque),
            )
            for touch in touches
        ],
    )
