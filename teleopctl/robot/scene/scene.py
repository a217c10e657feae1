"""Records of a scene's content. Lengths in metres, angles in radians, masses in kilograms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from teleopctl.robot.scene.surface import Across, Surface
from teleopctl.robot.urdf import Mimic
from teleopctl.tf import Transform

Vector3 = tuple[float, float, float]
Rgba = tuple[float, float, float, float]
ShapeKind = Literal[
    "box", "sphere", "cylinder", "capsule", "ellipsoid", "plane", "mesh", "heightmap"
]
JointKind = Literal["fixed", "revolute", "prismatic", "ball"]
LightKind = Literal["directional", "point", "spot"]

NOWHERE = Transform()
WORLD = "world"


@dataclass(frozen=True, slots=True)
class SceneShape:
    """Visual or collision shape of a body in a world file.

    Attributes:
        kind: Kind of the geometry.
        size: Edges of a box; radius and length of a sphere, cylinder or capsule; radii of an
            ellipsoid; edges of a plane, 0 for infinite; scale of a mesh; width, depth and height of
            a heightmap.
        pose: Pose in the body's frame.
        touches: Whether the shape is a collision shape, instead of a visual.
        file: Path of a mesh or of a heightmap's image.
        rgba: Colour; None if the file gives none.
        friction: Coefficient of friction; None for the default.
        surface: Restitution, torsional and rolling friction; None for the defaults.
        across: Friction across a direction, if different from ``friction``.
        mass: Mass in kilograms; None to compute it from ``density``.
        density: Density in kg/m³; None for that of water.
        place: File and line, for messages; empty if unknown.
    """

    kind: ShapeKind
    size: Vector3
    pose: Transform = NOWHERE
    touches: bool = True
    file: Path | None = None
    rgba: Rgba | None = None
    friction: float | None = None
    surface: Surface | None = None
    across: Across | None = None
    mass: float | None = None
    density: float | None = None
    place: str = ""


@dataclass(frozen=True, slots=True)
class SceneSensor:
    """Sensor of a body or a joint in a world file.

    Attributes:
        element: ``<sensor>`` element; its own pose is ignored.
        pose: Pose in the frame of the body or joint.
    """

    # Any: an lxml element, as the readers of sensors take it.
    element: Any
    pose: Transform


@dataclass(frozen=True, slots=True)
class SceneInertial:
    """Mass and inertia of a body in a world file.

    Attributes:
        mass: Mass in kilograms.
        moments: xx, xy, xz, yy, yz, zz about the centre of mass, in kg m².
        pose: Pose of the centre of mass and of the axes of ``moments``, in the body's frame.
    """

    mass: float
    moments: tuple[float, float, float, float, float, float]
    pose: Transform = NOWHERE


@dataclass(frozen=True)
class SceneBody:
    """Rigid body of a model in a world file: shapes, inertia, sensors.

    Attributes:
        name: Name of the body in the model.
        pose: Pose in the model's frame.
        shapes: Visual and collision shapes.
        inertial: Mass and inertia; None to compute them from the shapes.
        gravity: Whether gravity acts on the body.
        self_collides: Whether the body collides with other bodies of its model; True unless the
            file disables it.
        sensors: Sensors of the body.
    """

    name: str
    pose: Transform
    shapes: tuple[SceneShape, ...]
    inertial: SceneInertial | None = None
    gravity: bool = True
    self_collides: bool = True
    sensors: tuple[SceneSensor, ...] = ()


@dataclass(frozen=True)
class SceneJoint:
    """Joint between two bodies of a model in a world file.

    Attributes:
        name: Name of the joint in the model.
        kind: Type of the joint.
        parent: Name of the parent body; ``world`` for none.
        child: Name of the child body.
        pose: Pose in the model's frame.
        axis: Axis of rotation or translation, in the joint's frame.
        lower: Lower limit, rad or m; -inf for none.
        upper: Upper limit, rad or m; inf for none.
        effort: Effort limit, N m or N; inf for none.
        velocity: Velocity limit, rad/s or m/s; inf for none.
        damping: Viscous damping, N m s/rad or N s/m.
        friction: Dry friction, N m or N.
        stiffness: Spring stiffness, N m/rad or N/m.
        relaxed: Position of the relaxed spring, rad or m.
        mimic: Mimic relation to another joint, or None.
        sensors: Sensors of the joint.
        place: File and line, for messages.
        part_of: Joint of the file that this joint replaces together with others, such as
            "universal joint 'wrist'"; empty if the joint is the file's.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    pose: Transform
    axis: Vector3 = (0.0, 0.0, 1.0)
    lower: float = float("-inf")
    upper: float = float("inf")
    effort: float = float("inf")
    velocity: float = float("inf")
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    relaxed: float = 0.0
    mimic: Mimic | None = None
    sensors: tuple[SceneSensor, ...] = ()
    place: str = ""
    part_of: str = ""


@dataclass(frozen=True)
class SceneModel:
    """Model of a world file: its bodies, and the joints between the bodies.

    Attributes:
        name: Name of the model.
        pose: Pose in the world frame.
        bodies: Bodies of the model by name.
        joints: Joints between the bodies.
        static: Whether the model cannot move.
        plugins: ``<plugin>`` elements of the model.
        frames: Frames by name, including those of the bodies: the body that each frame is fixed
            to, and the pose in the model's frame.
    """

    name: str
    pose: Transform
    bodies: dict[str, SceneBody]
    joints: tuple[SceneJoint, ...] = ()
    static: bool = False
    # Any: lxml elements.
    plugins: tuple[Any, ...] = ()
    frames: Mapping[str, tuple[str, Transform]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SceneLight:
    """Light of a world (SDF or YAML): kind, colour, pose.

    Attributes:
        kind: Kind of the light.
        pose: Pose in the world frame.
        direction: Direction of the light, in its own frame.
        color: Diffuse colour: red, green and blue, 0 to 1.
        angle: Half the angle of a spot's cone, in radians.
        shadows: Whether the light casts shadows.
        specular: Specular colour: red, green and blue, 0 to 1.
        attenuation: Constant, linear and quadratic term: at d metres the light is divided by
            constant + linear d + quadratic d².
    """

    kind: LightKind
    pose: Transform
    direction: Vector3 = (0.0, 0.0, -1.0)
    color: Vector3 = (0.5, 0.5, 0.5)
    angle: float = 0.8
    shadows: bool = True
    specular: Vector3 = (0.3, 0.3, 0.3)
    attenuation: Vector3 = (1.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ScenePose:
    """Named pose in a world file, at which entities can be spawned.

    Attributes:
        name: Name of the pose.
        pose: Pose in the world frame.
        description: Description for users.
        tags: Tags by which poses are selected.
        size: Edges of the free box around the pose, along the pose's axes; None for no bounds.
    """

    name: str
    pose: Transform
    description: str = ""
    tags: tuple[str, ...] = ()
    size: Vector3 | None = None


@dataclass(frozen=True)
class Scene:
    """Content of a world file: models, lights, gravity and poses.

    Attributes:
        name: Name of the world in the file.
        models: Models of the world.
        lights: Lights of the world.
        gravity: Acceleration of free fall, m/s²; None if the file gives none.
        magnetic_field: Magnetic field in tesla; None if the file gives none.
        origin: Position of the world's origin on the earth: latitude and longitude in degrees,
            height above the ellipsoid in metres; None if the file gives none.
        remarks: Sentences about parts that are left out, each with its place in the file.
        files: Files that were read, the world file first.
        is_model: Whether the file is a single model instead of a world.
        poses: Named poses.
    """

    name: str
    models: tuple[SceneModel, ...]
    lights: tuple[SceneLight, ...] = ()
    gravity: Vector3 | None = None
    remarks: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()
    is_model: bool = False
    origin: Vector3 | None = None
    poses: tuple[ScenePose, ...] = ()
    magnetic_field: Vector3 | None = None
