"""Clearance: which bodies are near each other, and which of them count."""

import mujoco
import numpy as np
import pytest

from teleopctl.kinematics import ClearanceChecker, KinematicModel
from teleopctl.robot import RobotDescription

from .arms import SIX, arm


def boxes(*centres: tuple[float, float, float]):
    """Return a change of a model that adds boxes of 0.1 m to the world."""

    def change(spec):
        for number, centre in enumerate(centres):
            spec.worldbody.add_geom(
                name=f"box{number}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=[0.05, 0.05, 0.05],
                pos=list(centre),
            )

    return change


def numbers(model: KinematicModel, *names: str) -> list[int]:
    return [int(model.mj_model.geom(name).id) for name in names]


def test_all_is_found_that_is_nearer_than_the_distance_among_many_shapes_of_one_body():
    # MuJoCo leaves out bodies with several shapes as a whole, by a margin of their own.
    links = "".join(f'<link name="{name}"/>' for name in ("base",))
    shapes = "".join(
        f'<collision><origin xyz="{0.1 * n} 0 0"/><geometry><sphere radius="0.02"/></geometry>'
        "</collision>"
        for n in range(5)
    )
    robot = (
        f'<robot name="r">{links}<link name="bar">{shapes}</link><joint name="j" type="revolute">'
        '<parent link="base"/><child link="bar"/><axis xyz="0 0 1"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>'
    )
    model = KinematicModel(RobotDescription.from_urdf(robot)).with_changes(
        boxes((0.4, 0.3, 0.0), (0.0, 5.0, 0.0), (3.0, 0.0, 0.0))
    )
    (found,) = ClearanceChecker(model).near(0.25)
    assert found.distance_m == pytest.approx(0.3 - 0.05 - 0.02)


def test_shapes_of_an_object_carry_its_name_and_are_one_pair_with_a_link():
    model = arm(SIX).model.with_changes(boxes((0.15, 0.0, 0.9), (0.16, 0.0, 0.9)))
    clearance = ClearanceChecker(model, objects={"shelf": numbers(model, "box0", "box1")})
    found = [one for one in clearance.near(0.15) if "shelf" in one.bodies]
    assert len(found) == len({one.bodies for one in found})
    assert {link for one in found for link in one.bodies} >= {"link_3", "link_4", "shelf"}
    assert not any(one.is_self for one in found)


def test_a_pair_that_may_touch_by_a_rule_is_left_out_with_its_distances():
    model = arm(SIX).model.with_changes(boxes((0.0, 0.0, 0.95)))
    objects = {"box": numbers(model, "box0")}
    assert ClearanceChecker(model, objects=objects).collisions()
    clearance = ClearanceChecker(
        model, objects=objects, may_touch=lambda first, second: "box" in (first, second)
    )
    assert not clearance.collisions()
    assert not len(clearance.distances(0.0)[0])


def test_padding_brings_objects_nearer_and_links_not():
    kinematics = arm(SIX)
    model = kinematics.model.with_changes(boxes((0.3, 0.0, 0.9)))
    m = model.mj_model
    padding = np.where(m.geom_bodyid == model.links["link_4"], 0.05, 0.0)
    objects = {"box": numbers(model, "box0")}
    plain = {
        one.bodies: one.distance_m for one in ClearanceChecker(model, objects=objects).near(0.3)
    }
    clearance = ClearanceChecker(model, objects=objects, padding_m=padding)
    padded = {one.bodies: one.distance_m for one in clearance.near(0.3)}
    for bodies, distance in padded.items():
        nearer = 0.05 if bodies == ("link_4", "box") else 0.0
        assert distance == pytest.approx(plain[bodies] - nearer), bodies
    least = min(padded.values())
    assert clearance.distances(0.3)[0].min() == pytest.approx(least)


def test_distances_are_those_of_the_nearest_pairs():
    model = arm(SIX).model.with_changes(boxes((0.2, 0.1, 0.9), (0.2, -0.2, 0.5)))
    clearance = ClearanceChecker(model)
    distances, bodies = clearance.distances(0.3)
    least: dict[tuple[int, ...], float] = {}
    for distance, pair in zip(distances.tolist(), bodies.tolist(), strict=True):
        key = tuple(sorted(pair))
        least[key] = min(distance, least.get(key, np.inf))
    near = {tuple(sorted(one.numbers)): one.distance_m for one in clearance.near(0.3)}
    assert least == pytest.approx(near)
