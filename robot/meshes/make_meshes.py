"""Make the binary STL files of the teleop arm: ``python robot/meshes/make_meshes.py``.

Each part is built in metres in the frame of its link, where its proportions can be read off, and
is then moved into the frame of its file: the URDF draws a file at a given origin and at a scale
of 0.01, so the file holds the part seen from that origin, 100 units to the metre.

Needs the extra ``meshes`` (manifold3d for the solids).
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold
from trimesh.transformations import compose_matrix

UNITS_PER_METRE = 100.0

Vector = tuple[float, float, float]

# Where the two fingers turn, in the frame of claw_support, and the radius at which they mesh.
_RIGHT_AXIS = (-0.04, 0.13)
_LEFT_AXIS = (-0.22, 0.13)
_CLAW_MIDDLE = (_RIGHT_AXIS[0] + _LEFT_AXIS[0]) / 2
_PITCH_RADIUS = (_RIGHT_AXIS[0] - _LEFT_AXIS[0]) / 2
_FINGER_Z = -0.1
_TEETH = 16


@dataclass(frozen=True)
class Part:
    """A mesh file: how its solid is made and where the URDF puts it in its link."""

    file: str
    make: Callable[[], Manifold]
    origin: Vector
    rpy: Vector = (0.0, 0.0, 0.0)


def box(low: Vector, high: Vector, chamfer: float = 0.0) -> Manifold:
    """Make a box between two corners, its edges cut by ``chamfer``."""
    size = np.subtract(high, low)
    if not chamfer:
        return Manifold.cube(tuple(size)).translate(low)
    slabs = []
    for axis in range(3):
        inset = np.full(3, chamfer)
        inset[axis] = 0.0
        slabs.append(Manifold.cube(tuple(size - 2 * inset)).translate(tuple(low + inset)))
    return Manifold.batch_hull(slabs)


def disc(
    radius: float,
    start: Vector,
    length: float,
    axis: str = "z",
    *,
    chamfer: float = 0.0,
    segments: int = 32,
) -> Manifold:
    """Make a cylinder that starts at a point and runs along an axis, its rims chamfered."""
    body = Manifold.cylinder(length, radius, radius, segments)
    if chamfer:
        waist = Manifold.cylinder(length - 2 * chamfer, radius, radius, segments)
        core = Manifold.cylinder(length, radius - chamfer, radius - chamfer, segments)
        body = Manifold.batch_hull([waist.translate((0, 0, chamfer)), core])
    turn = {"x": (0, 90, 0), "y": (-90, 0, 0), "z": (0, 0, 0)}[axis]
    return body.rotate(turn).translate(start)


def plate_x(outline: CrossSection, low: float, high: float) -> Manifold:
    """Extrude an outline in the (y, z) plane from x = low to x = high."""
    # extrusion is along z: (y, z, x) turns into (x, y, z) by a cyclic change of axes
    return outline.extrude(high - low).rotate((90, 0, 90)).translate((low, 0, 0))


def plate_z(outline: CrossSection, low: float, high: float) -> Manifold:
    """Extrude an outline in the (x, y) plane from z = low to z = high."""
    return outline.extrude(high - low).translate((0, 0, low))


def circle(x: float, y: float, radius: float, segments: int = 20) -> CrossSection:
    """Make a filled circle in the plane."""
    return CrossSection.circle(radius, segments).translate((x, y))


def capsule(circles: Iterable[CrossSection]) -> CrossSection:
    """Make the outline that a belt around circles would take."""
    return CrossSection.batch_hull(list(circles))


def union(*solids: Manifold) -> Manifold:
    """Join solids into one."""
    total = Manifold()
    for solid in solids:
        total += solid
    return total


def servo(low: Vector, high: Vector) -> Manifold:
    """Make a servo's case: a chamfered box with a band around its middle."""
    middle = (low[2] + high[2]) / 2
    band = 0.006
    return box(low, high, 0.01) + box(
        (low[0] - band, low[1] - band, middle - 0.012),
        (high[0] + band, high[1] + band, middle + 0.012),
    )


def basement() -> Manifold:
    """Square plinth, 1 m wide and 0.3 m high, with a window for the camera in its front."""
    square = CrossSection.square((0.84, 0.84), True)

    def layer(width: float, low: float, high: float) -> Manifold:
        # rounded corners, the same number of points at each width
        return plate_z(square.offset(width - 0.42, circular_segments=14), low, high)

    body = Manifold.batch_hull([layer(0.5, 0.05, 0.27), layer(0.47, 0.03, 0.3)])
    groove = layer(0.52, 0.075, 0.085) - layer(0.488, 0.075, 0.085)
    body -= groove
    for x in (-0.38, 0.38):
        for y in (-0.38, 0.38):
            body += disc(0.06, (x, y, 0.0), 0.05, segments=14)
            # socket-head screws in the corners
            body -= disc(0.028, (x, y, 0.285), 0.05, segments=12)
            body += disc(0.02, (x, y, 0.27), 0.022, segments=6)
    bearing = disc(0.33, (0, 0, 0.29), 0.017)
    window = Manifold.batch_hull(
        [
            box((-0.09, 0.335, 0.11), (0.09, 0.34, 0.275)),
            box((-0.14, 0.52, 0.08), (0.14, 0.53, 0.275)),
        ]
    )
    return body + bearing - window


def base_plate() -> Manifold:
    """Turntable, 0.78 m across, with the two cheeks that hold the shoulder servo."""
    shoulder = (0.0, 0.35)
    shoulder_x = -0.02
    table = disc(0.39, (0, 0, 0.0), 0.055, chamfer=0.012, segments=40)
    step = disc(0.30, (0, 0, 0.05), 0.04, segments=40)
    bolts = [
        disc(0.018, (0.345 * math.cos(a), 0.345 * math.sin(a), 0.05), 0.016, segments=6)
        for a in np.arange(8) * math.pi / 4
    ]
    foot = CrossSection.square((0.28, 0.02), True).translate((0, 0.09))
    cheek = capsule([circle(*shoulder, 0.085), foot]) - circle(0, 0.2, 0.035, 20)
    cheeks = [plate_x(cheek, shoulder_x + low, shoulder_x + low + 0.04) for low in (0.075, -0.115)]
    horn = disc(0.05, (shoulder_x - 0.13, *shoulder), 0.02, "x", chamfer=0.004, segments=14)
    axle = disc(0.02, (shoulder_x - 0.12, *shoulder), 0.24, "x", segments=14)
    case = servo((shoulder_x + 0.11, -0.06, 0.24), (shoulder_x + 0.21, 0.06, 0.41))
    return union(table, step, *bolts, *cheeks, horn, axle, case)


def forward_drive_arm() -> Manifold:
    """Upper arm along z, 0.8 m between its axes, with the elbow's servo on its outer side."""
    elbow = (0.0, 0.8)
    beam = capsule([circle(0, 0, 0.085), circle(*elbow, 0.075)])
    body = plate_x(beam, -0.06, 0.06)
    # a channel on both sides leaves a web, and holes in the web save weight
    channel = capsule([circle(0, 0.16, 0.045), circle(0, 0.64, 0.038)])
    body -= plate_x(channel, 0.02, 0.1) + plate_x(channel, -0.1, -0.02)
    for z, radius in ((0.2, 0.032), (0.33, 0.03), (0.46, 0.028), (0.59, 0.026)):
        body -= disc(radius, (-0.1, 0, z), 0.2, "x", segments=12)
    boss = disc(0.06, (-0.07, 0, 0), 0.14, "x", chamfer=0.006, segments=14)
    shaft = disc(0.03, (-0.19, *elbow), 0.2, "x", segments=14)
    case = servo((0.055, -0.055, 0.7), (0.135, 0.055, 0.86))
    return union(body, boss, shaft, case)


def horizontal_arm() -> Manifold:
    """Forearm along y, 0.82 m to the claw, with a short tail behind the elbow."""
    low, high = _CLAW_MIDDLE - 0.045, _CLAW_MIDDLE + 0.045
    beam = capsule([circle(0, 0, 0.085), circle(0.74, 0, 0.05)])
    tail = capsule([circle(0, 0, 0.075), circle(-0.17, 0, 0.045)])
    body = plate_x(beam + tail, low, high)
    channel = capsule([circle(0.15, 0, 0.038), circle(0.66, 0, 0.024)])
    body -= plate_x(channel, low - 0.01, low + 0.025) + plate_x(channel, high - 0.025, high + 0.01)
    for y, radius in ((0.2, 0.026), (0.33, 0.024), (0.46, 0.022), (0.58, 0.019)):
        body -= disc(radius, (low - 0.1, y, 0), 0.3, "x", segments=12)
    hub = disc(0.07, (low - 0.02, 0, 0), high - low + 0.035, "x", chamfer=0.008, segments=24)
    cap = disc(0.035, (low - 0.032, 0, 0), 0.02, "x", segments=6)
    weight = box((low - 0.012, -0.225, -0.05), (high + 0.012, -0.13, 0.05), 0.012)
    flange = box((low - 0.03, 0.775, -0.08), (high + 0.03, 0.805, 0.08), 0.008)
    rib = capsule([circle(0.78, 0.06, 0.012), circle(0.78, -0.06, 0.012), circle(0.62, 0, 0.03)])
    return union(body, hub, cap, weight, flange, plate_x(rib, high - 0.055, high - 0.035))


def claw_support() -> Manifold:
    """Carrier of the fingers: a back plate and two shelves with the fingers' axles between."""
    middle, half = _CLAW_MIDDLE, 0.13
    back = box((middle - half, -0.016, -0.18), (middle + half, 0.02, 0.07), 0.008)
    corners = [circle(middle + side * (half - 0.02), 0.02, 0.02, 16) for side in (-1, 1)]
    axles = (_RIGHT_AXIS, _LEFT_AXIS)
    shelf = capsule([*corners, *(circle(x, y, 0.055) for x, y in axles)])
    upper = plate_z(shelf - circle(middle, 0.1, 0.03, 20), _FINGER_Z + 0.05, _FINGER_Z + 0.075)
    lower = plate_z(shelf, _FINGER_Z - 0.075, _FINGER_Z - 0.05)
    pins = [disc(0.02, (x, y, _FINGER_Z - 0.085), 0.17, segments=18) for x, y in axles]
    heads = [disc(0.032, (x, y, _FINGER_Z - 0.087), 0.015, segments=6) for x, y in axles]
    case = servo(
        (_RIGHT_AXIS[0] - 0.045, _RIGHT_AXIS[1] - 0.09, _FINGER_Z + 0.07),
        (_RIGHT_AXIS[0] + 0.035, _RIGHT_AXIS[1] + 0.04, _FINGER_Z + 0.16),
    )
    cap = disc(0.03, (*_LEFT_AXIS, _FINGER_Z + 0.07), 0.015, segments=14)
    return union(back, upper, lower, *pins, *heads, case, cap)


def gear(first_tooth: float) -> CrossSection:
    """Make a spur gear around the origin that has a tooth at the angle ``first_tooth``."""
    root, tip = _PITCH_RADIUS - 0.010, _PITCH_RADIUS + 0.008
    pitch = 2 * math.pi / _TEETH
    points = []
    for tooth in range(_TEETH):
        centre = first_tooth + tooth * pitch
        for radius, part in ((root, -0.33), (tip, -0.14), (tip, 0.14), (root, 0.33)):
            angle = centre + part * pitch
            points.append((radius * math.cos(angle), radius * math.sin(angle)))
    return CrossSection([points])


def finger(side: int) -> Manifold:
    """Curved finger, 0.5 m long along y; ``side`` is 1 for the right one, -1 for the left one.

    At zero the pads of the two fingers stand 4 mm apart. A tooth of the right gear points at the
    left one, whose gear is turned by half a tooth, so that they mesh at every angle.
    """
    # centre line and half width, for the right finger, whose partner is at smaller x
    spine = [
        (0.000, 0.020, 0.060),
        (0.045, 0.110, 0.036),
        (0.075, 0.195, 0.032),
        (0.078, 0.260, 0.030),
        (0.045, 0.335, 0.027),
        (-0.015, 0.395, 0.024),
    ]
    joints = [circle(x, y, half, 12) for x, y, half in spine]
    outline = CrossSection()
    for near, far in pairwise(joints):
        outline += capsule([near, far])
    pad_x = -_PITCH_RADIUS + 0.002
    pad = CrossSection(
        [[(pad_x, 0.372), (-0.015, 0.372), (-0.02, 0.42), (pad_x + 0.022, 0.5), (pad_x, 0.5)]]
    )
    outline += pad
    for index in range(8):
        # ridges to grip with
        outline -= circle(pad_x, 0.386 + 0.0145 * index, 0.0038, 4)
    # the gear's tooth towards the partner is at -x
    first_tooth = math.pi if side > 0 else math.pi + math.pi / _TEETH
    body = plate_z(outline, -0.035, 0.035) + plate_z(gear(first_tooth), -0.042, 0.042)
    body -= plate_z(circle(0, 0, 0.024, 20), -0.1, 0.1)
    for x, y in ((0.062, 0.150), (0.079, 0.225)):
        body -= plate_z(circle(x, y, 0.014, 10), -0.1, 0.1)
    return body if side > 0 else body.mirror((1, 0, 0))


def pi_camera() -> Manifold:
    """Small board with a lens that looks along x; the optical centre is at the origin."""
    board = box((-0.045, -0.05, -0.05), (-0.037, 0.05, 0.05))
    for y in (-0.04, 0.04):
        for z in (-0.04, 0.04):
            board -= disc(0.006, (-0.06, y, z), 0.04, "x", segments=8)
    holder = box((-0.04, -0.028, -0.028), (-0.02, 0.028, 0.028), 0.003)
    barrel = disc(0.021, (-0.025, 0, 0), 0.022, "x", segments=14)
    barrel -= disc(0.014, (-0.01, 0, 0), 0.02, "x", segments=14)
    connector = box((-0.05, -0.03, -0.05), (-0.04, 0.03, -0.035))
    return union(board, holder, barrel, connector)


_QUARTER = math.pi / 2

PARTS = (
    Part("basement.STL", basement, (-0.5, -0.5, 0.0)),
    Part("base_plate.STL", base_plate, (-0.39, -0.39, -0.56)),
    Part("forward_drive_arm.STL", forward_drive_arm, (0.19, 0.06, -0.08), (0, -_QUARTER, _QUARTER)),
    Part("horizontal_arm.STL", horizontal_arm, (-0.03, -0.4, -0.06), (_QUARTER, 0, _QUARTER)),
    Part("claw_support.STL", claw_support, (0.0, -0.05, -0.15), (0, 0, _QUARTER)),
    Part("right_finger.STL", lambda: finger(1), (-0.1, 0.5, -0.1), (0, 0, -_QUARTER)),
    Part("left_finger.STL", lambda: finger(-1), (-0.04, 0.5, -0.1), (0, 0, -_QUARTER)),
    Part("pi_camera.STL", pi_camera, (-0.05, -0.05, -0.05)),
)


def to_file_frame(part: Part) -> trimesh.Trimesh:
    """Build a part and express it in the frame and the units of its file."""
    mesh = part.make().to_mesh()
    solid = trimesh.Trimesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))
    link_from_file = compose_matrix(translate=part.origin, angles=part.rpy)
    solid.apply_transform(np.linalg.inv(link_from_file))
    solid.apply_scale(UNITS_PER_METRE)
    return solid


def main(folder: Path) -> None:
    """Write every file into a folder."""
    for part in PARTS:
        solid = to_file_frame(part)
        if not solid.is_watertight:
            raise SystemExit(f"{part.file}: the solid has holes")
        (folder / part.file).write_bytes(solid.export(file_type="stl"))


if __name__ == "__main__":
    main(Path(__file__).resolve().parent)
