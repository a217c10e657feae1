"""What a robot moves about with, from its description, and where a fixed one stands."""

import numpy as np
import pytest

from teleopctl.mujoco_model import FixedBy, build_model
from teleopctl.robot import Pose, RobotDescription
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import INERTIAL, box, control, joint, link, robot

SIDEWAYS = '<origin rpy="1.5707963 0 0"/>'
ENDLESS = {"kind": "continuous", "limit": ""}
PLACES = ((0.3, 0.2), (0.3, -0.2), (-0.3, 0.2), (-0.3, -0.2))


def shape(size: str, xyz: str = "0 0 0", kind: str = "collision") -> str:
    return INERTIAL + box(kind, size, xyz)


def round_shape(geometry: str, kind: str = "collision", origin: str = SIDEWAYS) -> str:
    return f"{INERTIAL}<{kind}>{origin}<geometry>{geometry}</geometry></{kind}>"


TYRE = round_shape('<cylinder radius="0.1" length="0.05"/>')


def vehicle(wheel: str = TYRE, *, kind: str = "continuous", body: str = "0.6 0.4 0.1") -> list[str]:
    """A flat body on four wheels whose axles are 0.1 m above the ground."""
    parts = [link("body", shape(body, "0 0 0.1"))]
    limit = "" if kind == "continuous" else 'lower="-1" upper="1" effort="1" velocity="1"'
    for number, (x, y) in enumerate(PLACES):
        xyz = f"{x} {y} 0"
        parts.append(link(f"wheel{number}", wheel))
        parts.append(
            joint(
                f"axle{number}", "body", f"wheel{number}", kind=kind, xyz=xyz, axis="0 1 0",
                limit=limit,
            )
        )  # fmt: skip
    return parts


def leg(name: str, xyz: str, parent: str = "body") -> list[str]:
    """Two links of 0.3 m that hang down."""
    return [
        link(f"{name}_thigh", shape("0.04 0.04 0.26", "0 0 -0.15")),
        link(f"{name}_shank", shape("0.04 0.04 0.3", "0 0 -0.15")),
        joint(f"{name}_hip", parent, f"{name}_thigh", xyz=xyz, axis="0 1 0"),
        joint(f"{name}_knee", f"{name}_thigh", f"{name}_shank", xyz="0 0 -0.3", axis="0 1 0"),
    ]


def chain(root: str, count: int, xyz: str, *, kind: str = "revolute", size: str) -> list[str]:
    """Links that follow one another, each joint at ``xyz`` in the link before."""
    parts = []
    limit = "" if kind == "continuous" else 'lower="-2" upper="2" effort="20" velocity="3"'
    before = root
    for number in range(count):
        middle = " ".join(str(float(part) / 2) for part in xyz.split())
        parts += [
            link(f"{root}_{number}", shape(size, middle)),
            joint(
                f"{root}_joint{number}", before, f"{root}_{number}", kind=kind,
                xyz=xyz if number else "0 0 0", axis="0 1 0" if number else "0 0 1", limit=limit,
            ),
        ]  # fmt: skip
        before = f"{root}_{number}"
    return parts


def fingers(parent: str, xyz: str, down: float) -> list[str]:
    return [
        part
        for side in (-1, 1)
        for part in (
            link(f"finger{side}", shape(f"0.02 0.02 {abs(down)}", f"0 0 {down / 2}")),
            joint(
                f"slide{side}",
                parent,
                f"finger{side}",
                kind="prismatic",
                axis="0 1 0",
                xyz=f"{xyz.rsplit(' ', 2)[0]} {0.03 * side} {xyz.rsplit(' ', 1)[1]}",
                limit='lower="-0.02" upper="0.02" effort="5" velocity="1"',
            ),
        )
    ]


ARM = [
    link("base", shape("0.2 0.2 0.1", "0 0 0.05")),
    *chain("base", 6, "0 0 0.2", size="0.05 0.05 0.18"),
]
BODY = link("body", shape("0.6 0.3 0.1"))

MOVE_ABOUT = {
    "a box": [link("box", shape("1 1 1"))],
    "a box of two links": [
        link("box", shape("1 1 1")),
        link("lid", shape("1 1 0.1")),
        joint("glue", "box", "lid", kind="fixed"),
    ],
    "wheels": vehicle(),
    "spheres for wheels": vehicle(round_shape('<sphere radius="0.1"/>', origin="")),
    "boxes for wheels": vehicle(shape("0.2 0.05 0.2")),
    "wheels that are drawn alone": vehicle(
        round_shape('<cylinder radius="0.1" length="0.05"/>', "visual")
    ),
    "a body that drags": vehicle(body="0.6 0.4 0.42"),
    "an arm on wheels": [
        *vehicle(),
        link("mount", ""),
        joint("bolts", "body", "mount", kind="fixed", xyz="0 0 0.15"),
        *chain("mount", 5, "0 0 0.2", size="0.05 0.05 0.18"),
    ],
    "four legs": [
        BODY,
        *(p for n, (x, y) in enumerate(PLACES) for p in leg(f"l{n}", f"{x} {y} 0")),
    ],
    "two legs": [
        link("body", shape("0.2 0.3 0.2", "0 0 0.1")),
        *leg("left", "0 0.1 0"),
        *leg("right", "0 -0.1 0"),
        link("chest", shape("0.2 0.4 0.4", "0 0 0.2")),
        joint("waist", "body", "chest", xyz="0 0 0.2"),
    ],
    "two legs below a chest": [
        link("chest", shape("0.2 0.4 0.4", "0 0 0.2")),
        link("pelvis", shape("0.2 0.3 0.1", "0 0 -0.1")),
        joint("waist", "chest", "pelvis", xyz="0 0 0"),
        *leg("left", "0 0.1 -0.1", "pelvis"),
        *leg("right", "0 -0.1 -0.1", "pelvis"),
    ],
    "legs without shapes": [
        link("body", ""),
        *(
            part
            for y in (-0.1, 0.1)
            for part in (
                link(f"leg{y}", INERTIAL),
                link(f"foot{y}", ""),
                joint(f"hip{y}", "body", f"leg{y}", xyz=f"0 {y} 0"),
                joint(f"sole{y}", f"leg{y}", f"foot{y}", kind="fixed", xyz="0 0 -0.5"),
            )
        ),
    ],
    "rotors": [
        BODY,
        *(
            part
            for n, (x, y) in enumerate(PLACES)
            for part in (
                link(f"rotor{n}", shape("0.2 0.02 0.01")),
                joint(f"spin{n}", "body", f"rotor{n}", xyz=f"{x} {y} 0.1", axis="0 0 1", **ENDLESS),
            )
        ),
    ],
    "a snake": [
        link("head", shape("0.2 0.05 0.05", "-0.1 0 0")),
        *chain("head", 8, "0.2 0 0", size="0.18 0.05 0.05"),
    ],
    "a plug-in": [
        *ARM,
        '<gazebo><plugin name="p" filename="gz-sim-multicopter-motor-model-system"/></gazebo>',
    ],
}
STAND_STILL = {
    "an arm": ARM,
    "an arm whose joints go round without end": [
        link("base", shape("0.2 0.2 0.1", "0 0 0.05")),
        *chain("base", 6, "0 0 0.2", kind="continuous", size="0.05 0.05 0.18"),
    ],
    "an arm that lies on the ground": [
        link("base", shape("0.3 0.3 0.2", "0 0 0.1")),
        *chain("base", 4, "0.3 0 0.01", size="0.28 0.05 0.05"),
    ],
    "an arm that hangs from its base, with a gripper": [
        link("base", shape("0.2 0.2 0.1", "0 0 0.05")),
        *chain("base", 5, "0 0 -0.2", size="0.05 0.05 0.18"),
        *fingers("base_4", "0 0 -0.2", -0.1),
    ],
    "a gripper": [
        link("palm", shape("0.1 0.2 0.05", "0 0 0.025")),
        *fingers("palm", "0 0 0.05", 0.1),
    ],
    "a gripper that points down": [
        link("palm", shape("0.1 0.2 0.3", "0 0 0.15")),
        *fingers("palm", "0 0 0", -0.02),
    ],
    "two arms on a column": [
        link("column", shape("0.3 0.3 1.2", "0 0 0.6")),
        *leg("left", "0 0.4 1", "column"),
        *leg("right", "0 -0.4 1", "column"),
    ],
    "a door": [
        link("frame", shape("0.1 0.05 2", "0 0 1")),
        link("door", shape("0.8 0.03 1.9", "0.45 0 1")),
        joint("hinge", "frame", "door", xyz="0 0 0", axis="0 0 1"),
    ],
    "drawers": [
        link("box", shape("0.5 0.5 1", "0 0 0.5")),
        link("drawer", shape("0.4 0.4 0.2", "0.1 0 0.1")),
        joint("rail", "box", "drawer", kind="prismatic", xyz="0 0 0", axis="1 0 0"),
    ],
    "a sensor that turns": [
        link("base", shape("0.1 0.1 0.05")),
        link("head", round_shape('<cylinder radius="0.04" length="0.04"/>', origin="")),
        joint("spin", "base", "head", xyz="0 0 0.05", axis="0 0 1", **ENDLESS),
    ],
    "wheels that do not turn": [
        *vehicle(kind="fixed"),
        link("head", shape("0.1 0.1 0.1")),
        joint("neck", "body", "head", xyz="0 0 0.3"),
    ],
    "a pendulum that goes round": [
        link("base", shape("0.2 0.2 1", "0 0 0.5")),
        link("rod", shape("0.02 0.02 0.9", "0 0 -0.45")),
        joint("hinge", "base", "rod", xyz="0.2 0 1", axis="1 0 0", **ENDLESS),
    ],
}


@pytest.mark.parametrize("kind", MOVE_ABOUT)
def test_what_moves_about_or_has_no_joints_is_free(kind: str) -> None:
    model = build_model(robot(*MOVE_ABOUT[kind]))
    assert model.fixed is None
    assert model.base is not None


@pytest.mark.parametrize("kind", STAND_STILL)
def test_what_has_neither_legs_nor_wheels_is_fixed_to_the_world(kind: str) -> None:
    description = robot(*STAND_STILL[kind])
    model = build_model(description)
    assert (model.base, model.free_bodies) == (None, ())
    assert model.fixed is not None
    assert (model.fixed.link, model.fixed.by) == (description.root, FixedBy.SHAPES)


def arm(*more: str) -> RobotDescription:
    return robot(*ARM, *more)


def static(word: str) -> str:
    return f"<gazebo><static>{word}</static></gazebo>"


@pytest.mark.parametrize(
    ("description", "asked", "by"),
    [
        (arm(), None, FixedBy.SHAPES),
        (arm(), True, FixedBy.ASKED),
        (arm(), False, None),
        (arm(static("false")), None, None),
        (arm(static("false")), True, FixedBy.ASKED),
        (arm(static("true")), None, FixedBy.STATIC),
        (arm(static("true")), False, FixedBy.STATIC),
        (robot(*vehicle(), static("true")), None, FixedBy.STATIC),
        (robot(*vehicle()), True, FixedBy.ASKED),
    ],
)
def test_who_says_whether_it_stands_is_obeyed(
    description: RobotDescription, asked: bool | None, by: FixedBy | None
) -> None:
    fixed = build_model(description, fixed_base=asked).fixed
    assert (fixed and fixed.by) is by


def test_an_arm_that_swings_does_not_tip() -> None:
    joints = [f"base_joint{number}" for number in range(6)]
    model = build_model(arm(control(**dict.fromkeys(joints, "position"))))
    simulation = Simulation(model, control_period_ns=10_000_000)
    for _ in range(300):
        simulation.apply(joints, [0.0, 1.2, 0.3, 0.0, 0.0, 0.0])
        simulation.step(10)
    simulation.read()
    assert simulation.positions == pytest.approx([0.0, 1.2, 0.3, 0.0, 0.0, 0.0], abs=1e-6)
    assert simulation.link_pose("base").position == pytest.approx([0, 0, 0])


def test_a_fixed_robot_stands_where_its_spawn_pose_says() -> None:
    model = build_model(arm(), spawn_pose=Pose((1.0, 2.0, 0.5), (0.1, 0.2, 0.3)))
    pose = Simulation(model, control_period_ns=10_000_000).link_pose("base")
    assert pose.position == pytest.approx([1.0, 2.0, 0.5])
    # Yaw after pitch after roll, multiplied out.
    assert pose.quaternion == pytest.approx([0.98334744, 0.03427080, 0.10602051, 0.14357218])
    assert model.world_frame == "world"
    assert build_model(arm()).world_frame == "base"


def test_a_fixed_robot_is_raised_out_of_the_ground() -> None:
    hanging = STAND_STILL["an arm that hangs from its base, with a gripper"]
    model = build_model(robot(*hanging), spawn_pose=Pose((1.0, 0.0, 0.0)))
    simulation = Simulation(model, control_period_ns=10_000_000)
    simulation.step(1)
    _, data = simulation.observe()
    # Five links of 0.2 m, and fingers of 0.1.
    assert simulation.link_pose("base").position == pytest.approx([1.0, 0.0, 1.1], abs=0.11)
    assert simulation.link_pose("finger1").position[2] == pytest.approx(0.1)
    assert not np.any(data.contact.dist < -1e-6)
