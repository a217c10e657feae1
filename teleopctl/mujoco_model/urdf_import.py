"""Changes of a URDF before MuJoCo compiles it, among them invalid shapes.

Descriptions of real robots have invalid shapes as placeholders. MuJoCo rejects a whole robot for
one of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from lxml import etree

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model.contacts import set_friction
from teleopctl.mujoco_model.surroundings.surfaces import store_surface
from teleopctl.robot import repair_urdf

if TYPE_CHECKING:
    from collections.abc import Iterator

    from teleopctl.robot import RobotDescription

_GEOM = mujoco.mjtGeom
# Name of each shape, and how many of MuJoCo's three sizes it has.
_SIZED = {
    _GEOM.mjGEOM_BOX: ("box", 3),
    _GEOM.mjGEOM_SPHERE: ("sphere", 1),
    _GEOM.mjGEOM_CYLINDER: ("cylinder", 2),
    _GEOM.mjGEOM_CAPSULE: ("capsule", 2),
}


def drop_impossible_shapes(spec: mujoco.MjSpec) -> list[str]:
    """Remove shapes with invalid sizes from a spec; return a warning per link."""
    warnings: list[str] = []
    for body in spec.bodies:
        impossible = list(_impossible(body))
        if not impossible:
            continue
        kinds = ", ".join(dict.fromkeys(_SIZED[geom.type][0] for geom in impossible))
        warnings.append(
            f"Shapes of link '{body.name}' ({kinds}) are left out: "
            "their sizes must be positive, finite numbers"
        )
        for geom in impossible:
            spec.delete(geom)
    return warnings


# Any stands for MuJoCo's bodies and geoms, whose classes have no types.
def _impossible(body: Any) -> Iterator[Any]:
    for geom in body.geoms:
        _, count = _SIZED.get(geom.type, ("", 0))
        sizes = np.asarray(geom.size)[:count]
        if not (np.isfinite(sizes).all() and (sizes > 0.0).all()):
            yield geom


# Ground and robot visuals are drawn, collision shapes only when a viewer enables group 3.
VISUAL_GROUP = 1
COLLISION_GROUP = 3
# Shapes that are neither drawn nor touched, but define the mass of links without another mass.
WEIGHING_GROUP = 4

_COMPILER = {"fusestatic": "false", "discardvisual": "false", "strippath": "false"}


def import_urdf(urdf: str) -> mujoco.MjSpec:
    """Return the ``mujoco.MjSpec`` of URDF text, without mimic constraints; raise if invalid.

    Args:
        urdf: The expanded robot description.

    Returns:
        The spec: bodies, joints and geometry as in the URDF, meshes by their URIs.

    Raises:
        InvalidDescriptionError: If MuJoCo does not accept the description; the message is MuJoCo's.
    """
    text = _with_compiler_options(urdf)
    try:
        spec = mujoco.MjSpec.from_string(text)
    except ValueError as error:
        message = " ".join(str(error).split())
        raise InvalidDescriptionError(
            f"The robot description cannot be simulated: {message}"
        ) from error
    for geom in spec.geoms:
        geom.group = COLLISION_GROUP if geom.contype else VISUAL_GROUP
    show_bare_collisions(spec)
    return spec


def apply_gazebo(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    """Apply ``<gazebo reference="…">`` tags to a spec: colours, friction, weightlessness, springs.

    Links get colours, friction, surfaces and gravity compensation; joints get springs.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        description: Robot description that ``spec`` was made from.
    """
    default = float(spec.default.geom.friction[0])
    for link, properties in description.gazebo.links.items():
        body = spec.body(link)
        if body is None:
            continue
        if not properties.gravity:
            body.gravcomp = 1.0
        for geom in body.geoms:
            if properties.rgba is not None:
                geom.rgba[:3] = properties.rgba[:3]
            if properties.mu1 is not None:
                set_friction(geom, properties.mu1, default)
            if properties.surface is not None:
                store_surface(geom, properties.surface)
    for name, spring in description.gazebo.springs.items():
        joint = spec.joint(name)
        if joint is not None:
            # As in Gazebo, fixed joints and joints with several axes have no springs.
            joint.stiffness[0], joint.springref = spring.stiffness, spring.relaxed


def _with_compiler_options(urdf: str) -> str:
    try:
        # The text is already decoded; a robot description needs no entities.
        parser = etree.XMLParser(
            encoding="utf-8", resolve_entities=False, remove_comments=True, remove_pis=True
        )
        robot = etree.fromstring(urdf.encode(), parser)
    except etree.XMLSyntaxError as error:
        raise InvalidDescriptionError(f"The robot description is not XML: {error.msg}") from error
    repair_urdf(robot)
    for joint in robot.iterfind("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
    extension = robot.find("mujoco")
    if extension is None:
        extension = etree.SubElement(robot, "mujoco")
        # MuJoCo applies the options to the elements after them.
        robot.insert(0, extension)
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = etree.SubElement(extension, "compiler")
    compiler.attrib.update(_COMPILER)
    text: str = etree.tostring(robot, encoding="unicode")
    return text


def show_bare_collisions(spec: mujoco.MjSpec) -> None:
    """Make collision shapes visible on links that have no visual shapes."""
    for body in spec.bodies:
        geoms = list(body.geoms)
        if all(geom.group == COLLISION_GROUP for geom in geoms):
            for geom in geoms:
                geom.group = VISUAL_GROUP
