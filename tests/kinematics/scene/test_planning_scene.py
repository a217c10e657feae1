"""The planning scene: objects around a robot and in its hand, and what may touch what."""

import numpy as np
import pytest

from teleopctl.errors import NotFoundError, UsageError
from teleopctl.kinematics import (
    AllowedCollisions,
    AttachedBody,
    CollisionBody,
    CollisionScene,
    CollisionShape,
    KinematicModel,
    ShapeKind,
)

from ..arms import SIX, arm

# The arm stands upright: link_4 at 0.9 to 1.0 m, tool0 at 1.2 m.
BESIDE, ON_LINK_4 = (0.5, 0.0, 0.95), (0.0, 0.0, 0.95)


@pytest.fixture(scope="module")
def model() -> KinematicModel:
    return arm(SIX).model


@pytest.fixture
def scene(model) -> CollisionScene:
    return CollisionScene(model)


def pose(*at: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = at
    return matrix


def thing(name: str, at: tuple[float, float, float], shape: CollisionShape | None = None, **more):
    shape = shape or CollisionShape.primitive(ShapeKind.BOX, (0.1, 0.1, 0.1))
    return CollisionBody(name, pose(*at), (shape,), (np.eye(4),), **more)


def touching(scene: CollisionScene) -> set[tuple[str, ...]]:
    return {tuple(sorted(one.bodies)) for one in scene.compiled().clearance.collisions()}


def distance_m(scene: CollisionScene, name: str) -> float:
    near = scene.compiled().clearance.near(2.0)
    return min(one.distance_m for one in near if name in one.bodies)


def test_an_object_is_an_obstacle_until_it_is_removed(scene):
    assert touching(scene) == set()
    scene.add(thing("box", ON_LINK_4))
    assert ("box", "link_4") in touching(scene)
    scene.remove("box")
    assert touching(scene) == set()


def test_an_object_of_the_same_name_replaces_the_one_before(scene):
    scene.add(thing("box", ON_LINK_4))
    scene.add(thing("box", BESIDE))
    assert touching(scene) == set()
    scene.remove("box")
    scene.add(thing("box", ON_LINK_4))
    assert ("box", "link_4") in touching(scene)


def test_moved_and_appended_shapes_count_where_they_are(scene):
    scene.add(thing("box", BESIDE))
    scene.append(thing("box", ON_LINK_4))
    assert ("box", "link_4") in touching(scene)
    scene.move("box", pose(0.5, 0.0, 2.0))
    assert touching(scene) == set()
    scene.move("box", pose(*BESIDE), [pose(-0.5, 0.0, 0.0), np.eye(4)])
    assert ("box", "link_4") in touching(scene)
    with pytest.raises(UsageError, match="has 2 shapes, got 1 poses"):
        scene.move("box", pose(*BESIDE), [np.eye(4)])


@pytest.mark.parametrize(
    ("shape", "nearest"),
    [
        (CollisionShape.primitive(ShapeKind.BOX, (0.2, 0.1, 0.4)), 0.5 - 0.03 - 0.1),
        (CollisionShape.primitive(ShapeKind.SPHERE, (0.1,)), 0.5 - 0.03 - 0.1),
        (CollisionShape.primitive(ShapeKind.CYLINDER, (0.4, 0.1)), 0.5 - 0.03 - 0.1),
        # At its base, 0.2 m below the middle, where link_3 is.
        (CollisionShape.primitive(ShapeKind.CONE, (0.4, 0.1)), 0.5 - 0.03 - 0.1),
        (CollisionShape.plane(1.0, 0.0, 0.0, 0.1), 0.4 - 0.03),
        # Its normal away from the robot.
        (CollisionShape.plane(-2.0, 0.0, 0.0, -0.2), 0.4 - 0.03),
    ],
    ids=lambda value: value.kind.name.lower() if isinstance(value, CollisionShape) else "",
)
def test_each_shape_has_its_size(scene, shape, nearest):
    scene.add(thing("it", BESIDE, shape))
    assert distance_m(scene, "it") == pytest.approx(nearest, abs=1e-3)


def test_what_a_link_carries_moves_with_it_and_is_checked(scene, model):
    scene.add(
        thing("stick", (0.0, 0.0, 1.2), CollisionShape.primitive(ShapeKind.BOX, (0.8, 0.02, 0.02)))
    )
    scene.add(
        thing("wall", (0.0, 0.38, 1.2), CollisionShape.primitive(ShapeKind.BOX, (0.2, 0.04, 0.2)))
    )
    scene.attach(AttachedBody(scene.take("stick", "tool0"), "tool0"))
    assert "stick" not in scene.objects
    compiled = scene.compiled()
    assert not compiled.clearance.collisions()
    compiled.model.set_positions({"joint_5": np.pi / 2})
    assert [{*one.bodies} for one in compiled.clearance.collisions()] == [{"stick", "wall"}]
    assert model.positions()["joint_5"] == 0.0


def test_what_is_carried_touches_its_link_and_touch_links_and_nothing_else(scene):
    long = CollisionShape.primitive(ShapeKind.BOX, (0.02, 0.02, 0.6))
    scene.add(thing("pole", (0.0, 0.0, 1.2), long))
    scene.attach(AttachedBody(scene.take("pole", "tool0"), "tool0"))
    # link_6 carries it; link_5 is beyond a joint.
    assert touching(scene) == {("link_4", "pole"), ("link_5", "pole")}
    held = scene.attached["pole"]
    scene.attach(AttachedBody(held.object, held.link, frozenset({"link_4", "link_5"})))
    assert touching(scene) == set()


def test_links_on_either_side_of_a_joint_stay_no_pair_while_something_is_carried(scene):
    before = touching(scene)
    scene.add(thing("cube", (0.0, 0.0, 1.3), CollisionShape.primitive(ShapeKind.SPHERE, (0.01,))))
    scene.attach(AttachedBody(scene.take("cube", "tool0"), "tool0"))
    near = {one.bodies for one in scene.compiled().clearance.near(0.05)}
    assert touching(scene) == before
    assert ("link_5", "link_6") not in near


def test_a_detached_object_stays_where_it_was_carried_to(scene, model):
    scene.add(thing("cube", (0.0, 0.0, 1.25)))
    scene.attach(AttachedBody(scene.take("cube", "tool0"), "tool0"))
    model.set_positions({"joint_2": np.pi / 2})
    try:
        scene.detach("cube")
        assert scene.objects["cube"].pose[:3, 3] == pytest.approx((1.1, 0.0, 0.15), abs=1e-9)
    finally:
        model.set_positions({"joint_2": 0.0})


def test_a_held_body_of_the_simulation_may_touch_what_it_lies_on(scene):
    scene.add(thing("table", (0.0, 0.0, 1.35)))
    scene.add(thing("cube", (0.0, 0.0, 1.25), is_free=True, is_simulated=True))
    assert scene.attach(AttachedBody(scene.take("cube", "tool0"), "tool0")) == ["table"]
    assert ("cube", "table") not in touching(scene)


def test_padding_and_scale_keep_links_away_from_objects(scene):
    scene.add(thing("box", BESIDE))
    plain = distance_m(scene, "box")
    scene.padding_m["link_4"] = 0.02
    scene.changed()
    assert distance_m(scene, "box") == pytest.approx(plain - 0.02)
    scene.scale["link_4"] = 1.5
    scene.changed()
    assert distance_m(scene, "box") < plain - 0.02


def test_frames_are_links_objects_and_their_subframes(scene, model):
    scene.add(thing("box", BESIDE, subframes={"handle": pose(0.0, 0.0, 0.1)}))
    assert scene.frame("tool0") == pytest.approx(model.pose("tool0"))
    assert scene.frame("box/handle")[:3, 3] == pytest.approx((0.5, 0.0, 1.05))
    scene.attach(AttachedBody(scene.take("box", "tool0"), "tool0"))
    assert scene.frame("box/handle")[:3, 3] == pytest.approx((0.5, 0.0, 1.05))
    assert scene.fixed_to("box")[0] == "tool0"
    assert scene.frame("nothing") is None


def test_a_copy_is_changed_alone_and_restored(scene):
    scene.add(thing("box", BESIDE))
    before = scene.copy()
    scene.clear()
    scene.allowed.set("a", "b", is_allowed=True)
    assert list(before.objects) == ["box"]
    scene.restore(before)
    assert list(scene.objects) == ["box"]
    assert not scene.allowed.is_allowed("a", "b")


def test_unknown_names_and_empty_objects_are_refused_with_what_there_is(scene):
    scene.add(thing("box", BESIDE))
    with pytest.raises(NotFoundError, match="no collision object 'bx'") as error:
        scene.remove("bx")
    assert error.value.hint == "There are: box"
    with pytest.raises(NotFoundError, match="no link 'hand'"):
        scene.attach(AttachedBody(scene.objects["box"], "hand"))
    with pytest.raises(UsageError, match="'empty' has no shape"):
        scene.add(CollisionBody("empty", np.eye(4), (), ()))
    with pytest.raises(UsageError, match="needs an id"):
        scene.add(thing("", BESIDE))


def test_entries_of_pairs_come_before_defaults():
    allowed = AllowedCollisions([("a", "b")])
    assert allowed.is_allowed("b", "a")
    allowed.set_default("a", is_allowed=False)
    allowed.set_default("c", is_allowed=True)
    assert allowed.is_allowed("a", "b")
    assert allowed.is_allowed("c", "d")
    assert not allowed.is_allowed("a", "c")
    allowed.forget("b")
    assert not allowed.is_allowed("a", "b")
