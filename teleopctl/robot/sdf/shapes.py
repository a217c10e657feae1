"""Shapes, colours and masses of SDF links."""

from __future__ import annotations

import math
from typing import Any

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.robot.gazebo_tag import gazebo_colour
from teleopctl.robot.scene.scene import Rgba, SceneInertial, SceneShape, ShapeKind, Vector3
from teleopctl.robot.scene.surface import Across, Surface, expressed_in, read_surface
from teleopctl.robot.sdf.includes import find_file
from teleopctl.robot.sdf.reading import SdfFile
from teleopctl.robot.tags import sdf as tags
from teleopctl.robot.urdf_text import rotation_from_z
from teleopctl.tf import Transform, rotate

# Gazebo's default colour.
_GREY = (0.7, 0.7, 0.7)
# Shapes whose size is three numbers in one tag.
_OF_THREE = {"box": "size", "ellipsoid": "radii"}


# Any, here and below: lxml elements, whose class has no types.
def read_shape(file: SdfFile, element: Any, pose: Transform) -> SceneShape | None:
    """Read a ``<visual>`` or ``<collision>`` as a `SceneShape`; None if it is left out.

    Args:
        file: SDF file of the shape.
        element: ``<visual>`` or ``<collision>`` element.
        pose: Pose of the shape in its link.

    Raises:
        InvalidDescriptionError: A number of the shape is invalid.
    """
    touches = element.tag == "collision"
    file.check_tags(element, tags.COLLISION if touches else tags.VISUAL)
    geometry = element.find("geometry")
    solid = None if geometry is None else next(iter(geometry), None)
    if solid is None:
        file.leave_out(element, "is left out: it has no shape")
        return None
    file.check_tags(geometry, tags.GEOMETRY)
    for other in list(geometry)[1:]:
        file.leave_out(other, "is left out: of several shapes the first is used")
    if solid.tag == "empty":
        return None
    found = _geometry(file, solid)
    if found is None:
        return None
    kind, size, path, turn = found
    friction = _friction(file, element) if touches else None
    density = file.number(element, "density", math.nan)
    return SceneShape(
        kind,
        size,
        pose @ turn,
        touches,
        path,
        None if touches else _colour(file, element),
        friction,
        _surface(file, element) if touches else None,
        _across(file, element, pose, friction) if touches else None,
        density=None if math.isnan(density) else density,
        place=file.place(solid),
    )


def _friction(file: SdfFile, collision: Any) -> float | None:
    """Return the coefficient of friction of a shape; None if unset."""
    coefficient = file.number(collision, "surface/friction/ode/mu", math.nan)
    if coefficient < 0.0:
        return math.inf  # as in Gazebo
    return None if math.isnan(coefficient) else coefficient


def _across(
    file: SdfFile, collision: Any, pose: Transform, friction: float | None
) -> Across | None:
    """Return the friction across ``<fdir1>``; None if equal to ``mu``, or without a direction."""
    across = collision.find("surface/friction/ode/mu2")
    if across is None:
        return None
    coefficient = file.number(across, ".", math.nan)
    coefficient = math.inf if coefficient < 0.0 else coefficient
    if coefficient == friction:
        return None
    x, y, z = file.vector(collision, "surface/friction/ode/fdir1", (0.0, 0.0, 0.0))
    if not any((x, y, z)):
        file.leave_out(across, "has no effect: friction is <mu> in all directions")
        return None
    link = expressed_in(collision.find("surface/friction/ode/fdir1"))
    return Across(coefficient, (x, y, z) if link else rotate(pose.rotation, (x, y, z)), link)


def _surface(file: SdfFile, collision: Any) -> Surface | None:
    return read_surface(lambda path, usual: file.number(collision, f"surface/{path}", usual))


def read_inertial(file: SdfFile, link: Any, place: Transform) -> SceneInertial | None:
    """Return the inertia of an SDF link; None if ``auto`` requests computing from the shapes.

    A link without the element has SDF's default: 1 kg, and moments of 1 kg m².

    Args:
        file: SDF file of the link.
        link: ``<link>`` element.
        place: Pose of the ``<inertial>`` in the link.

    Raises:
        InvalidDescriptionError: A number is invalid, or the mass or a moment is negative.
    """
    element = link.find("inertial")
    if element is None:
        return SceneInertial(1.0, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
    if element.get("auto") == "true":
        return None
    mass = file.number(element, "mass", 1.0)
    if not 0.0 <= mass < math.inf:
        raise InvalidDescriptionError(
            f"{file.place(element)}: link '{link.get('name')}' has a mass of {mass:g} kg"
        )
    moments = tuple(
        file.number(element, f"inertia/i{axes}", 1.0 if axes[0] == axes[1] else 0.0)
        for axes in ("xx", "xy", "xz", "yy", "yz", "zz")
    )
    if min(moments[0], moments[3], moments[5]) < 0.0:
        raise InvalidDescriptionError(
            f"{file.place(element)}: link '{link.get('name')}' has a negative moment of inertia"
        )
    xx, xy, xz, yy, yz, zz = moments
    return SceneInertial(mass, (xx, xy, xz, yy, yz, zz), place)


_Found = tuple[ShapeKind, Vector3, Any, Transform]


def _geometry(file: SdfFile, solid: Any) -> _Found | None:
    match solid.tag:
        case "box" | "sphere" | "cylinder" | "capsule" | "ellipsoid":
            kind: ShapeKind = solid.tag
            sizes = _sizes(file, solid)
            return None if sizes is None else (kind, sizes, None, Transform())
        case "cone":
            sizes = _sizes(file, solid)
            if sizes is None:
                return None
            radius, length, _ = sizes
            # It imports numpy, which a launch would otherwise do without.
            from teleopctl.robot.meshes import unit_cone_stl

            return "mesh", (radius, radius, length), unit_cone_stl(), Transform()
        case "plane":
            edges = solid.find("size")
            width, depth = (0.0, 0.0) if edges is None else file.numbers(edges, 2)
            turn = rotation_from_z(file.vector(solid, "normal", (0.0, 0.0, 1.0)))
            return "plane", (max(width, 0.0), max(depth, 0.0), 0.0), None, turn
        case "mesh":
            return _mesh(file, solid)
        case "heightmap":
            return _heightmap(file, solid)
    file.leave_out(solid)
    return None


def _mesh(file: SdfFile, solid: Any) -> _Found | None:
    path = _file(file, solid)
    if path is None:
        return None
    if solid.find("submesh") is not None:
        file.leave_out(solid.find("submesh"), "is left out: the whole mesh is used")
    return "mesh", file.vector(solid, "scale", (1.0, 1.0, 1.0)), path, Transform()


def _heightmap(file: SdfFile, solid: Any) -> _Found | None:
    path = _file(file, solid)
    if path is None:
        return None
    if path.suffix.lower() != ".png":
        file.leave_out(solid, "is left out: its heights are not a PNG image")
        return None
    size = file.vector(solid, "size", (1.0, 1.0, 1.0))
    if min(size) <= 0.0:
        file.leave_out(solid, f"is left out: its size is {size}, and should be positive")
        return None
    place = Transform(file.vector(solid, "pos", (0.0, 0.0, 0.0)))
    return "heightmap", size, path, place


def _file(file: SdfFile, solid: Any) -> Any:
    element = solid.find("uri")
    uri = "" if element is None else (element.text or "").strip()
    if not uri:
        file.leave_out(solid, "is left out: it names no file")
        return None
    try:
        path = find_file(uri, file.path.parent)
    except NotFoundError as error:
        file.leave_out(solid, f"is left out: {error.message}")
        return None
    if not path.is_file():
        file.leave_out(solid, f"is left out: {path} is not a file")
        return None
    return path.absolute()


def _sizes(file: SdfFile, solid: Any) -> Vector3 | None:
    """Return the sizes of a shape, by default 1 m; None with a remark if a size is invalid."""
    if solid.tag in _OF_THREE:
        found = list(file.vector(solid, _OF_THREE[solid.tag], (1.0, 1.0, 1.0)))
    else:
        tags = ("radius",) if solid.tag == "sphere" else ("radius", "length")
        found = [file.number(solid, tag, 1.0) for tag in tags]
    if all(0.0 < size < math.inf for size in found):
        a, b, c = (*found, 0.0, 0.0)[:3]
        return a, b, c
    file.leave_out(solid, "is left out: its sizes should be positive numbers")
    return None


def _colour(file: SdfFile, visual: Any) -> Rgba | None:
    opaque = 1.0 - file.number(visual, "transparency", 0.0)
    found = _opaque_colour(file, visual)
    if found is not None:
        return *found[:3], found[3] * opaque
    if opaque == 1.0:
        return None
    if visual.find("geometry/mesh") is None:
        return *_GREY, opaque
    file.leave_out(visual.find("transparency"), "has no effect on the colours of a mesh")
    return None


def _opaque_colour(file: SdfFile, visual: Any) -> Rgba | None:
    material = visual.find("material")
    if material is None:
        return None
    for path in ("pbr/metal/albedo_map", "pbr/specular/albedo_map"):
        picture = material.find(path)
        if picture is not None:
            file.leave_out(picture, "is left out: the shape has one colour")
    if material.find("diffuse") is not None:
        if material.find("ambient") is not None:
            # The scene's lights determine the colour in shadows.
            line = material.find("ambient").sourceline
            file.remarks.add_own(file.path, line or 0, "ambient")
        return _rgba(file, material.find("diffuse"))
    script = material.find("script/name")
    colour = None if script is None else gazebo_colour((script.text or "").strip())
    if colour is not None:
        return *colour, 1.0
    if script is not None:
        file.leave_out(script, f"'{(script.text or '').strip()}' is left out: not a known colour")
    return None if material.find("ambient") is None else _rgba(file, material.find("ambient"))


def _rgba(file: SdfFile, element: Any) -> Rgba:
    count = len((element.text or "").split())
    red, green, blue, *alpha = file.numbers(element, count if count in (3, 4) else 4)
    return red, green, blue, alpha[0] if alpha else 1.0
