"""MJCF files, read by MuJoCo, with a name for each part that ROS has to name.

Display, control and simulation read MJCF robots by this module, so that all use the same names.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.mjcf.size_limits import check_mjcf
from teleopctl.robot.urdf_text import transform
from teleopctl.tf import Transform

WORLD = "world"

_FREE = mujoco.mjtJoint.mjJNT_FREE
# The keyframe that a robot starts in.
_HOME = "home"


# Any, here and elsewhere: MuJoCo's classes have no static types.
@dataclass(frozen=True)
class Mjcf:
    """MJCF file that describes a robot, with its MuJoCo spec and compiled model.

    Attributes:
        path: Path of the file.
        spec: ``mujoco.MjSpec`` of the file, in which every body, joint and actuator has a name.
        model: Compiled ``mujoco.MjModel``.
        tops: Top-level bodies of the robot; other top-level bodies are its surroundings.
        home: Index of the keyframe ``home``; -1 for none.
    """

    path: Path
    spec: Any
    model: Any
    tops: tuple[int, ...]
    home: int

    @property
    def root(self) -> str:
        """Name of the root link: the robot's only top-level body if it is free, else ``world``."""
        if len(self.tops) == 1 and free_joint(self.model, self.tops[0]) is not None:
            return str(self.model.body(self.tops[0]).name)
        return WORLD

    def bodies(self) -> list[int]:
        """Return the MuJoCo indices of the robot's bodies, parents before children."""
        m = self.model
        return [body for body in range(1, m.nbody) if int(m.body_rootid[body]) in self.tops]

    def place(self, body: int) -> tuple[str, Transform] | None:
        """Return a body's URDF link and pose in that link; None for moving bodies of no robot.

        A body of the robot is a link itself; any other static body is fixed to the world. None for
        a moving body that is not part of the robot.
        """
        m = self.model
        top = int(m.body_rootid[body])
        if top in self.tops:
            return str(m.body(body).name), Transform()
        if m.body_weldid[body] != 0 or m.body_mocapid[top] >= 0:
            return None
        data = self.start()
        return WORLD, transform(data.xpos[body], data.xquat[body])

    def start(self) -> Any:
        """Return a new ``mujoco.MjData`` at the keyframe ``home``, or else at ``qpos0``."""
        data = mujoco.MjData(self.model)
        if self.home >= 0:
            mujoco.mj_resetDataKeyframe(self.model, data, self.home)
        mujoco.mj_kinematics(self.model, data)
        return data

    def keyframes(self) -> dict[str, Any]:
        """Return a new ``mujoco.MjData`` for each named keyframe, by name."""
        found = {}
        for number in range(self.model.nkey):
            if name := self.model.key(number).name:
                found[str(name)] = data = mujoco.MjData(self.model)
                mujoco.mj_resetDataKeyframe(self.model, data, number)
        return found


def load_mjcf(path: Path) -> Mjcf:
    """Read and compile an MJCF file with its includes; return it as an `Mjcf`, or raise.

    Raises:
        InvalidDescriptionError: MuJoCo rejects the file or would need too much memory for it, or
            the file has no bodies.
    """
    path = path.absolute()
    check_mjcf(path)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _name_parts(spec)
        model = spec.compile()
    except (ValueError, RuntimeError) as error:
        # MuJoCo raises RuntimeError for errors without a class, such as too little memory.
        message = " ".join(str(error).split())
        raise InvalidDescriptionError(f"{path}: MuJoCo refuses it: {message}") from error
    tops = _robot_of(model)
    if not tops:
        raise InvalidDescriptionError(
            f"{path}: it contains no robot: its world has no bodies",
            hint="A scene without a robot is a world: teleopctl launch sim.yaml world:=FILE",
        )
    home = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, _HOME)
    return Mjcf(path, spec, model, tops, int(home))


def free_joint(model: Any, body: int) -> int | None:
    """Return the index of a MuJoCo body's free joint, or None."""
    first = int(model.body_jntadr[body])
    has_one = int(model.body_jntnum[body]) == 1 and model.jnt_type[first] == _FREE
    return first if has_one else None


# Any: an enumerator of MuJoCo or its number.
def sensor_type(kind: Any) -> str:
    """Return the MJCF tag of a sensor type, such as ``gyro``, from MuJoCo's number."""
    name = str(mujoco.mjtSensor(int(kind)).name).removeprefix("mjSENS_").lower()
    return name.replace("actfrc", "actuatorfrc")


def joints_of(model: Any, body: int) -> range:
    """Return the indices of the joints that move a MuJoCo body in its parent."""
    first = int(model.body_jntadr[body])
    return range(first, first + int(model.body_jntnum[body]))


def _robot_of(model: Any) -> tuple[int, ...]:
    """Return the top bodies of the robot: those with joints, else the free ones, else all."""
    on_world = [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
    jointed = {
        int(model.body_rootid[model.jnt_bodyid[joint]])
        for joint in range(model.njnt)
        if model.jnt_type[joint] != _FREE
    }
    free = {body for body in on_world if free_joint(model, body) is not None}
    return tuple(body for body in on_world if body in (jointed or free or set(on_world)))


def _name_parts(spec: Any) -> None:
    for kind, elements in (
        ("body", spec.bodies),
        ("joint", spec.joints),
        ("actuator", spec.actuators),
        ("tendon", spec.tendons),
        ("camera", spec.cameras),
        ("sensor", spec.sensors),
    ):
        taken = {element.name for element in elements}
        for element in elements:
            if not element.name:
                wanted = _names_for(kind, element)
                element.name = next(name for name in wanted if name not in taken)
                taken.add(element.name)


def _names_for(kind: str, element: Any) -> Iterator[str]:
    """Yield names for an element without one, by its owner or a number."""
    owner = {
        "joint": lambda: element.parent.name,
        "actuator": lambda: element.target,
        "sensor": lambda: element.objname,
    }.get(kind)
    name = owner() if owner is not None else ""
    if kind == "sensor":
        kind = sensor_type(element.type)
    if name:
        yield f"{name}_{kind}"
    yield from (f"{name or kind}_{number}" for number in range(1, 1_000_000))
