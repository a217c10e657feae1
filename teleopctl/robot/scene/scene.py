"""What stands and lies in a scene. Lengths in metres, angles in radians, masses in kilograms."""

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
        kind: What it is.
        size: A box: its edges; sphere, cylinder, capsule: radius, length; ellipsoid: radii; a
            plane: its edges, 0 for no end; mesh: its scale; heightmap: width, depth, height.
        pose: Where it is in its body.
        touches: Whether it is felt rather than seen.
        file: The file of a mesh or the picture of a heightmap.
        rgba: Its colour; None for one that nobody gave it.
        friction: Its coefficient of friction; None for the usual one.
        surface: How it bounces, spins and rolls; None for as usual.
        across: Its friction in other directions, where that is another one.
        mass: In kilograms; None for that by its density, where it is asked for.
        density: In kg/m³; None for that of water.
        place: Its file and line, for messages; empty where nobody needs them.
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
        element: Its ``<sensor>``, whose own pose does not count.
        pose: Where it is in the body, or in the joint's frame.
    """

    # Any: an element of lxml, which whoever reads sensors takes.
    element: Any
    pose: Transform


@dataclass(frozen=True, slots=True)
class SceneInertial:
    """Mass and inertia of a body in a world file.

    Attributes:
        mass: In kilograms.
        moments: xx, xy, xz, yy, yz, zz about the centre of mass, in kg m².
        pose: Of the centre of mass and the axes of the moments, in the body.
    """

    mass: float
    moments: tuple[float, float, float, float, float, float]
    pose: Transform = NOWHERE


@dataclass(frozen=True)
class SceneBody:
    """Rigid body of a model in a world file: shapes, inertia, sensors.

    Attributes:
        name: Its name in the model.
        pose: Where it is in the model.
        shapes: What it looks like and touches with.
        inertial: Its mass; None where it is that of its shapes.
        gravity: Whether it falls.
        self_collides: Whether it touches the other parts of its model; only where the file says
            that it does not, it does not.
        sensors: What measures on it.
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
        name: Its name in the model.
        kind: How it moves.
        parent: The body that it starts at; ``world`` for none.
        child: The body that it moves.
        pose: Where it is in the model.
        axis: Of its turn or its slide, in its own frame.
        lower: Its lower limit; -inf for none.
        upper: Its upper limit.
        effort: The most effort, N m or N; inf for any.
        velocity: The greatest speed; inf for any.
        damping: N m s/rad or N s/m.
        friction: N m or N.
        stiffness: Of its spring, N m/rad or N/m.
        relaxed: Where its spring pulls to, rad or m.
        mimic: The joint that it follows, or None.
        sensors: What measures on it.
        place: Its file and line, for messages.
        part_of: What it is, with others, in the place of; empty for nothing.
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
        name: Its name.
        pose: Where it is.
        bodies: Its parts by name.
        joints: What is between them.
        static: Whether it stands still.
        plugins: Its ``<plugin>`` elements.
        frames: Its frames by name, those of its bodies too: the body that each is fixed to, and
            where it is in the model.
    """

    name: str
    pose: Transform
    bodies: dict[str, SceneBody]
    joints: tuple[SceneJoint, ...] = ()
    static: bool = False
    # Any: as of `SceneSensor`.
    plugins: tuple[Any, ...] = ()
    frames: Mapping[str, tuple[str, Transform]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SceneLight:
    """Light of a world (SDF or YAML): kind, colour, pose.

    Attributes:
        kind: What kind of one.
        pose: Where it is.
        direction: Where it shines, in its own frame.
        color: Its red, green and blue.
        angle: Half the angle of a spot's cone.
        shadows: Whether it casts shadows.
        specular: What of it shiny things throw back: red, green and blue.
        attenuation: How it fades at d metres: by 1 / (constant + linear d + quadratic d²).
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
        name: Its name.
        pose: Where it is.
        description: What it is, for people.
        tags: What it is for.
        size: The edges of the box around it, along its own axes, that is free; None for no bounds.
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
        name: What it calls itself.
        models: What stands and lies in it.
        lights: What shines.
        gravity: The acceleration of free fall; None where it says nothing.
        magnetic_field: In tesla; None where it says nothing.
        origin: Where its origin is on the earth: latitude and longitude in degrees, metres above
            the ellipsoid; None where it says nothing.
        remarks: What is left out, a sentence each with its place in the file.
        files: The files that it was made from, the file itself first.
        is_model: Whether the file is one thing rather than a world.
        poses: Its places with names.
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
