"""Transforms that come over topics: what waits for them, and what is asked in other frames."""

import threading

import pytest

from teleopctl.interfaces.store import get_action, get_message
from teleopctl.node import (
    ActionServer,
    Context,
    Duration,
    Node,
    SingleThreadedExecutor,
    Time,
)
from teleopctl.tf.broadcaster import StaticTransformBroadcaster
from teleopctl.tf.buffer import Buffer
from teleopctl.tf.buffer_client import BufferClient
from teleopctl.tf.conversions import ConvertRegistration, TypeException, convert
from teleopctl.tf.errors import LookupException, TimeoutException, TransformException
from teleopctl.tf.geometry import do_transform_pose, register, transform_covariance
from teleopctl.tf.listener import TransformListener
from teleopctl.tf.messages import transform_stamped
from teleopctl.tf.transforms import Transform, quaternion_from_rpy

register()  # what importing tf2_geometry_msgs does

QUARTER = quaternion_from_rpy(0.0, 0.0, 1.5707963267948966)


def stamped(parent, child, x=0.0, rotation=(0.0, 0.0, 0.0, 1.0)):
    return transform_stamped(parent, child, 0, Transform((x, 0.0, 0.0), rotation))


def message(name, frame, **fields):
    made = get_message(f"geometry_msgs/msg/{name}")(**fields)
    made.header.frame_id = frame
    return made


@pytest.fixture
def node(ros, monkeypatch):
    for name, value in ros.env.items():
        monkeypatch.setenv(name, value)
    with Context() as context, Node("watcher", context=context) as node:
        yield node


@pytest.fixture
def executor(node):
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)
        yield executor


def test_spinning_once_gets_on_with_each_message(node, executor):
    buffer = Buffer()
    TransformListener(buffer, node)
    StaticTransformBroadcaster(node).sendTransform(stamped("world", "base", 1.0))
    while not buffer.can_transform("world", "base", Time()):
        executor.spin_once()


def test_a_coroutine_gets_a_transform_when_it_comes(node, executor):
    buffer = Buffer()
    TransformListener(buffer, node)
    task = executor.create_task(buffer.lookup_transform_async, "world", "base", Time())
    executor.spin_once(10.0)
    assert not task.done()
    StaticTransformBroadcaster(node).sendTransform(stamped("world", "base", 2.0))
    executor.spin_until_future_complete(task, 10.0)
    assert task.result().transform.translation.x == 2.0


def test_what_waits_is_called_back_by_who_spins(node, executor):
    buffer, threads = Buffer(), []
    TransformListener(buffer, node)
    future = buffer.wait_for_transform_async("world", "base", Time())
    future.add_done_callback(lambda _: threads.append(threading.current_thread()))
    StaticTransformBroadcaster(node).sendTransform(stamped("world", "base"))
    while not threads:
        executor.spin_once()
    assert threads == [threading.current_thread()]


def test_a_listener_may_spin_the_node_itself(node):
    ticked = threading.Event()
    node.create_timer(0.001, ticked.set)
    listener = TransformListener(Buffer(), node, spin_thread=True)
    assert ticked.wait(10.0)
    listener.unregister()
    listener.dedicated_listener_thread.join(10.0)
    assert not listener.dedicated_listener_thread.is_alive()


def test_a_buffer_with_a_node_offers_its_frames(node, executor):
    from teleopctl.interfaces.store import get_service

    Buffer(node=node).set_transform_static(stamped("world", "base"))
    graph = get_service("tf2_msgs/srv/FrameGraph")
    client = node.create_client(graph, "tf2_frames")
    assert client.wait_for_service(10.0)
    future = client.call_async(graph.Request())
    executor.spin_until_future_complete(future, 10.0)
    assert "parent: 'world'" in future.result().frame_yaml


def test_a_buffer_without_a_listener_answers_what_waits_at_once():
    buffer = Buffer()
    future = buffer.wait_for_transform_full_async("world", Time(), "base", Time(), "world")
    assert not future.done()
    buffer.set_transform_static(stamped("world", "base", 3.0))
    found = future.result()
    assert found is not None
    assert found.transform.translation.x == 3.0


def test_a_transform_that_arrives_while_another_thread_looks_is_not_missed():
    arrivals: list[threading.Thread] = []

    class Arriving(Buffer):
        def lookup_transform(self, *arguments):
            try:
                return super().lookup_transform(*arguments)
            except TransformException:
                if not arrivals:
                    transform = stamped("world", "base", 3.0)
                    arrival = threading.Thread(target=self.set_transform_static, args=[transform])
                    arrivals.append(arrival)
                    arrival.start()
                    # Until it has looked for futures in vain, or waits for this thread.
                    arrival.join(0.2)
                raise

    buffer = Arriving()
    future = buffer.wait_for_transform_async("world", "base", Time())
    arrivals[0].join(10.0)
    found = future.result()
    assert found is not None
    assert found.transform.translation.x == 3.0


@pytest.fixture
def buffer():
    made = Buffer()
    made.set_transform_static(stamped("world", "base", 1.0, QUARTER))
    return made


def test_points_move_and_vectors_only_turn(buffer):
    point = message("PointStamped", "base")
    point.point.x = 2.0
    moved = buffer.transform(point, "world")
    assert moved.header.frame_id == "world"
    assert (moved.point.x, moved.point.y) == pytest.approx((1.0, 2.0))
    vector = message("Vector3Stamped", "base")
    vector.vector.x = 2.0
    turned = buffer.transform(vector, "world").vector
    assert (turned.x, turned.y) == pytest.approx((0.0, 2.0))


def test_poses_move_with_their_covariance(buffer):
    pose = message("PoseWithCovarianceStamped", "base")
    pose.pose.covariance[0] = 4.0
    pose.pose.covariance[28] = 9.0
    moved = buffer.transform_full(pose, "world", Time(), "world").pose
    assert moved.pose.position.x == pytest.approx(1.0)
    assert moved.pose.orientation.z == pytest.approx(QUARTER[2])
    assert moved.covariance[7] == pytest.approx(4.0)
    assert moved.covariance[21] == pytest.approx(9.0)
    assert moved.covariance[0] == pytest.approx(0.0)


def test_a_covariance_keeps_its_cross_terms():
    covariance = [0.0] * 36
    covariance[3] = 1.0
    turned = transform_covariance(covariance, stamped("world", "base", 0.0, QUARTER))
    assert turned[10] == pytest.approx(1.0)


def test_polygons_move_corner_by_corner(buffer):
    polygon = message("PolygonStamped", "base")
    polygon.polygon.points = [get_message("geometry_msgs/msg/Point32")(x=float(x)) for x in (1, 2)]
    moved = buffer.transform(polygon, "world").polygon.points
    assert [corner.y for corner in moved] == pytest.approx([1.0, 2.0])


def test_a_type_that_nobody_registered_is_refused(buffer):
    with pytest.raises(TypeException, match="not registered"):
        buffer.transform(message("TwistStamped", "base"), "world")


def test_conversion_goes_through_the_message(buffer):
    class Place(tuple):
        pass

    point = get_message("geometry_msgs/msg/PointStamped")
    ConvertRegistration().add_from_msg(Place, lambda m: Place((m.point.x, m.point.y, m.point.z)))
    moved = buffer.transform(message("PointStamped", "base"), "world", new_type=Place)
    assert moved == pytest.approx((1.0, 0.0, 0.0))
    assert type(convert(message("PointStamped", "base"), point)) is point


def test_a_new_run_of_the_simulation_clears_what_moved(node):
    buffer = Buffer()
    TransformListener(buffer, node)
    clock = node.get_clock()
    clock.set_simulated(True)
    clock.set_simulated_time(100_000_000_000)
    buffer.set_transform(transform_stamped("a", "b", 99_000_000_000, Transform()))
    buffer.set_transform_static(stamped("a", "still"))
    clock.set_simulated_time(99_500_000_000)
    assert buffer.can_transform("a", "b", Time())
    clock.set_simulated_time(1_000_000_000)
    assert not buffer.can_transform("a", "b", Time())
    assert buffer.can_transform("a", "still", Time())
    buffer.set_transform(transform_stamped("a", "b", 1_000_000_000, Transform()))
    assert buffer.can_transform("a", "b", Time())


def test_a_buffer_of_another_process_is_asked_by_an_action(node, executor):
    known = Buffer()
    known.set_transform_static(stamped("world", "base", 1.0), "test")
    look_up = get_action("tf2_msgs/action/LookupTransform")

    def answer(goal):
        asked = goal.request
        found = look_up.Result()
        source = (asked.source_frame, asked.source_time)
        target = (asked.target_frame, asked.target_time)
        try:
            if asked.advanced:
                found.transform = known.lookup_transform_full(*target, *source, asked.fixed_frame)
            else:
                found.transform = known.lookup_transform(target[0], *source)
        except LookupException as error:
            found.error.error = found.error.LOOKUP_ERROR
            found.error.error_string = str(error)
        goal.succeed()
        return found

    client = BufferClient(node, "look_up", timeout_padding=Duration(seconds=20))
    with pytest.raises(TimeoutException, match="/look_up"):
        client.lookup_transform("world", "base", Time())
    with ActionServer(node, look_up, "look_up", answer):
        client.action_client.wait_for_server(20)
        spinning = threading.Thread(target=executor.spin)
        spinning.start()
        moved = client.transform(message("PointStamped", "base"), "world")
        assert moved.point.x == 1.0
        with pytest.raises(LookupException, match="nowhere"):
            client.lookup_transform("world", "nowhere", Time())
        assert not client.can_transform("world", "nowhere", Time())
        assert client.can_transform_full("world", Time(), "base", Time(), "world")
        executor.shutdown()
        spinning.join()
    client.destroy()


def test_a_turned_pose_has_the_quaternion_whose_w_is_not_negative():
    half = transform_stamped("world", "base", 0, Transform((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)))
    pose = get_message("geometry_msgs/msg/Pose")()
    pose.orientation.x, pose.orientation.w = 1.0, 0.0
    assert do_transform_pose(pose, half).orientation.w == 1.0
