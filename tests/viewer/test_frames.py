"""Where frames stand in the picture: where tf2 says."""

import math

import pytest
from hypothesis import given, strategies
from viser import ViserServer

from teleopctl.tf import (
    Transform,
    TransformException,
    quaternion_from_rpy,
    transform_stamped,
)
from teleopctl.viewer import open_server
from teleopctl.viewer.scene.frames import FrameBuffer, SceneFrames

NAMES = ("a", "b", "c", "d/e", "f", "g")


@pytest.fixture(scope="module")
def server():
    server: ViserServer = open_server(port=0)
    yield server
    server.stop()


@pytest.fixture
def frames(server):
    frames = SceneFrames(server.scene, FrameBuffer())
    yield frames
    frames.remove()


def put(frames, child, parent, transform, stamp=1, *, static=False):
    message = transform_stamped(parent, child, stamp, transform)
    (frames.buffer.set_transform_static if static else frames.buffer.set_transform)(message)


def shown(frames, name):
    """The pose that browsers have, or None where the frame is not shown."""
    node = frames.by_name[name].node
    if not node.visible:
        return None
    w, x, y, z = (float(part) for part in node.wxyz)
    px, py, pz = (float(part) for part in node.position)
    return Transform((px, py, pz), (x, y, z, w))


def test_what_stands_on_a_frame_moves_with_it(frames):
    put(frames, "arm", "base", Transform((1.0, 0.0, 0.0)))
    frames.update()
    assert frames.fixed == "base"
    assert shown(frames, "arm") == Transform((1.0, 0.0, 0.0))
    put(frames, "arm", "base", Transform((2.0, 0.0, 0.0)), 2)
    frames.update()
    assert shown(frames, "arm") == Transform((2.0, 0.0, 0.0))


def test_another_fixed_frame_turns_everything_round(frames):
    quarter = quaternion_from_rpy(0.0, 0.0, math.pi / 2)
    put(frames, "arm", "base", Transform((1.0, 0.0, 0.0), quarter))
    frames.set_fixed_frame("/arm")
    frames.update()
    assert frames.fixed == "arm"
    pose = shown(frames, "base")
    assert pose is not None
    assert pose.translation == pytest.approx((0.0, 1.0, 0.0))
    assert shown(frames, "arm") == Transform()


def test_a_frame_that_nothing_joins_to_the_fixed_one_is_not_shown(frames):
    put(frames, "arm", "base", Transform())
    put(frames, "wheel", "truck", Transform())
    frames.set_fixed_frame("base")
    frames.update()
    assert shown(frames, "wheel") is None
    put(frames, "truck", "base", Transform((0.0, 3.0, 0.0)), static=True)
    frames.update()
    assert shown(frames, "wheel") == Transform((0.0, 3.0, 0.0))


def test_a_frame_of_which_nobody_has_spoken_is_not_shown(frames):
    path = frames.node_path("ghost")
    put(frames, "arm", "base", Transform())
    frames.update()
    assert path == "/frames/ghost"
    assert shown(frames, "ghost") is None


trees = strategies.lists(
    strategies.tuples(
        strategies.integers(0, len(NAMES) - 1),
        strategies.tuples(*[strategies.floats(-10, 10)] * 3),
        strategies.tuples(*[strategies.floats(-3, 3)] * 3),
    ),
    min_size=1,
    max_size=len(NAMES) - 1,
)


@given(trees, strategies.sampled_from(NAMES))
def test_every_frame_stands_where_tf2_says(server, tree, fixed):
    frames = SceneFrames(server.scene, FrameBuffer())
    for number, (parent, xyz, rpy) in enumerate(tree):
        # Each frame stands in one of those before it, which makes a tree, or several.
        put(
            frames,
            NAMES[number + 1],
            NAMES[min(parent, number)],
            Transform(xyz, quaternion_from_rpy(*rpy)),
        )
    frames.set_fixed_frame(fixed)
    frames.update()
    for name in frames.by_name:
        pose = shown(frames, name)
        try:
            expected = frames.pose_in_fixed_frame(name)
        except TransformException:
            assert pose is None
        else:
            assert pose is not None
            assert pose.translation == pytest.approx(expected.translation, abs=1e-9)
            assert pose.rotation == pytest.approx(expected.rotation, abs=1e-9)
    frames.remove()


def test_frames_that_tf_never_knows_do_not_fill_the_memory(server, frames, monkeypatch):
    monkeypatch.setattr("teleopctl.viewer.scene.frames.MOST_UNKNOWN", 10)
    put(frames, "arm", "base", Transform())
    for number in range(100):
        frames.node_path(f"object_{number}")
        frames.update()
    assert sorted(frames.by_name, key=str) == sorted(
        ["arm", "base", *(f"object_{number}" for number in range(90, 100))]
    )
    assert len([name for name in server.scene._handle_from_node_name if "object_" in name]) == 10


def test_a_frame_that_was_forgotten_is_one_again_when_tf_knows_it(frames, monkeypatch):
    monkeypatch.setattr("teleopctl.viewer.scene.frames.MOST_UNKNOWN", 0)
    put(frames, "arm", "base", Transform())
    frames.node_path("late")
    frames.update()
    put(frames, "late", "base", Transform((1.0, 0.0, 0.0)))
    frames.update()
    assert shown(frames, "late") == Transform((1.0, 0.0, 0.0))
