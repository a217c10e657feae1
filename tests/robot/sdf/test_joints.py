"""Joints of SDF that are several of one axis here: what they become, and what is told of them."""

import math
from pathlib import Path

import pytest

from teleopctl.robot import ExpandedXacro, RobotDescription, read_model
from teleopctl.robot.urdf import Mimic

MASS = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"


def joint(kind: str, content: str, parent: str = "a", child: str = "b", name: str = "j") -> str:
    return (
        f"\n<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{child}</child>"
        f"{content}</joint>"
    )


def read(tmp_path: Path, *joints: str) -> tuple[RobotDescription, ExpandedXacro]:
    links = "".join(
        f"<link name='{name}'><pose>0 0 {z} 0 0 0</pose>{MASS}</link>"
        for z, name in enumerate("abc")
        if any(f">{name}<" in text for text in joints)
    )
    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.11'><model name='m'>{links}{''.join(joints)}</model></sdf>")
    expanded = read_model(file)
    return RobotDescription.from_urdf(expanded.text), expanded


def told(description: RobotDescription) -> list[str]:
    return [repair.rpartition(": the ")[2] for repair in description.repairs]


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_a_joint_with_two_axes_is_two_hinges_in_series(tmp_path: Path, kind: str) -> None:
    axes = (
        "<pose>0 0 -0.2 0 0 0</pose><axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper>"
        "<effort>7</effort></limit></axis><axis2><xyz>1 0 0</xyz><dynamics><damping>0.3</damping>"
        "</dynamics></axis2>"
    )
    description, _ = read(tmp_path, joint(kind, axes))
    first, second = description.joints["j_1"], description.joints["j_2"]

    assert (first.parent, first.child) == ("a", "j_link")
    assert (second.parent, second.child) == ("j_link", "b")
    assert (first.axis, second.axis) == ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    assert first.origin.xyz == pytest.approx((0.0, 0.0, 0.8))
    assert second.origin.xyz == pytest.approx((0.0, 0.0, 0.0))
    assert first.limit is not None
    assert (first.limit.lower, first.limit.upper, first.limit.effort) == (-1.0, 2.0, 7.0)
    assert second.type == "continuous"
    assert second.dynamics is not None
    assert second.dynamics.damping == 0.3
    assert told(description) == [
        f"{kind} joint 'j' becomes two joints: 'j_1' turns about its first axis, 'j_2' about "
        "its second"
    ]


@pytest.mark.parametrize(
    ("thread", "pitch_m"),
    [
        ("<screw_thread_pitch>0.01</screw_thread_pitch>", 0.01),
        # The older tag counts radians per metre, of a left-handed thread.
        ("<thread_pitch>-200</thread_pitch>", math.tau / 200.0),
        ("<thread_pitch>5</thread_pitch><screw_thread_pitch>-0.02</screw_thread_pitch>", -0.02),
        ("", 1.0),
    ],
)
def test_a_screw_turns_and_slides_by_its_pitch(tmp_path: Path, thread: str, pitch_m: float) -> None:
    description, _ = read(tmp_path, joint("screw", f"{thread}<axis><xyz>0 0 1</xyz></axis>"))
    slide = description.joints["j_slide"]

    assert slide.type == "prismatic"
    assert slide.mimic is not None
    assert slide.mimic.joint == "j"
    assert slide.mimic.multiplier == pytest.approx(pitch_m / math.tau)
    assert description.joints["j"].type == "continuous"
    assert told(description) == [
        "screw joint 'j' becomes two joints: 'j' turns, 'j_slide' slides with it"
    ]


HINGE = "<axis><xyz>0 0 {}</xyz></axis>"


@pytest.mark.parametrize(
    ("into", "out_of", "multiplier"),
    [
        (joint("revolute", HINGE.format(1)), ("a", "c", 1), -5.0),
        # One hinge turns the other way, or hangs the other way round.
        (joint("revolute", HINGE.format(-1)), ("a", "c", 1), 5.0),
        (joint("revolute", HINGE.format(1), "b", "a"), ("a", "c", 1), 5.0),
    ],
)
def test_a_gearbox_ties_the_hinges_of_its_links(
    tmp_path: Path, into: str, out_of: tuple[str, str, int], multiplier: float
) -> None:
    parent, child, way = out_of
    gearbox = joint(
        "gearbox",
        "<gearbox_ratio>5</gearbox_ratio><gearbox_reference_body>a</gearbox_reference_body>"
        "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2>",
        *("b", "c", "gears"),
    )
    output = joint("revolute", HINGE.format(way), parent, child, "k")
    description, _ = read(tmp_path, into, output, gearbox)

    assert set(description.joints) == {"j", "k"}
    assert description.joints["k"].mimic == Mimic("j", multiplier, 0.0)
    assert told(description) == []


def test_a_gearbox_without_hinges_is_told_with_its_line(tmp_path: Path) -> None:
    content = "<gearbox_reference_body>a</gearbox_reference_body>"
    hinge = joint("revolute", "<axis><xyz>1 0 0</xyz></axis>")
    output = joint("revolute", HINGE.format(1), "a", "c", "k")
    _, expanded = read(tmp_path, hinge, output, joint("gearbox", content, "b", "c", "gears"))
    assert (
        "model.sdf:4: &lt;joint&gt; 'gears' is left out: it needs hinges between its links and "
        "'a', along its axes" in expanded.text
    )


def test_a_joint_that_follows_one_of_two_axes_follows_that(tmp_path: Path) -> None:
    follows = "<axis><mimic joint='j' axis='axis2'><multiplier>2</multiplier></mimic></axis>"
    description, _ = read(
        tmp_path,
        joint("universal", "<axis/><axis2/>"),
        joint("revolute", follows, "b", "c", "k"),
    )
    assert description.joints["k"].mimic == Mimic("j_2", 2.0, 0.0)


def test_a_second_axis_and_a_pitch_where_they_mean_nothing_are_told(tmp_path: Path) -> None:
    content = "<thread_pitch>3</thread_pitch><axis/><axis2><xyz>1 0 0</xyz></axis2>"
    description, _ = read(tmp_path, joint("revolute", content))
    assert [repair.rpartition(": ")[2] for repair in description.repairs] == [
        "<thread_pitch> has no effect",
        "<axis2> is left out",
    ]
