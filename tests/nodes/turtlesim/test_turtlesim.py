"""Turtles move, draw, turn and end as in ROS 2's turtlesim."""

import math
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionClient, Node, Parameter, SingleThreadedExecutor, init
from teleopctl.nodes.turtlesim.board import LOOKS, SIZE, Board, Colour, Pen, turtle_picture
from teleopctl.nodes.turtlesim.node import TurtleSim
from teleopctl.nodes.turtlesim.turtle import TICK_S, normalize_angle
from teleopctl.nodes.turtlesim.tutorials import DrawSquare, TurtleMimic, TurtleTeleop
from teleopctl.testing import RosGraph

RED = Colour(255, 0, 0)
WHITE = Colour(255, 255, 255)


MIMIC = [
    *("--ros-args", "-r", "input/pose:=turtle1/pose"),
    *("-r", "output/cmd_vel:=turtle2/cmd_vel"),
]


class Session:
    """A simulation and a user's node in one process; the simulation's time is its ticks."""

    def __init__(self) -> None:
        self.sim = TurtleSim()
        self.sim.timers[0].cancel()
        self.user = Node("user")
        self.executor = SingleThreadedExecutor()
        self.add(self.sim, self.user)

    def add(self, *nodes: Node) -> None:
        for node in nodes:
            self.executor.add_node(node)

    def call(self, kind: str, name: str, /, **fields: Any) -> Any:
        type_ = get_service(kind)
        client = self.user.create_client(type_, name)
        assert client.wait_for_service(10.0)
        future = client.call_async(type_.Request(**fields))
        self.executor.spin_until_future_complete(future, 10.0)
        return future.result()

    def turtle(self, name: str = "turtle1") -> Any:
        return self.sim.turtles[name]

    def command(self, **fields: float) -> None:
        twist = get_message("geometry_msgs/msg/Twist")()
        twist.linear.x = fields.get("forward", 0.0)
        twist.linear.y = fields.get("sideways", 0.0)
        twist.angular.z = fields.get("turn", 0.0)
        self.turtle()._on_command(twist)

    def ticks(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.sim.tick()


@pytest.fixture
def session(ros: RosGraph) -> Iterator[Session]:
    del ros
    with init(args=[]):
        session = Session()
        yield session
        session.executor.shutdown()
        session.user.destroy_node()
        session.sim.destroy_node()


def place(turtle: Any) -> tuple[float, float, float]:
    return (turtle.x, SIZE - turtle.y, turtle.theta)


def test_it_begins_with_one_turtle_in_the_middle_and_ros2s_parameters(session):
    assert [*session.sim.turtles] == ["turtle1"]
    assert place(session.turtle()) == pytest.approx((5.544445, 5.544445, 0.0), abs=1e-6)
    assert session.sim.background == Colour(69, 86, 255)
    assert session.sim.get_parameter("holonomic").value is False
    (refused,) = session.sim.set_parameters([Parameter("background_r", value=256)])
    assert not refused.successful


def test_a_turtle_drives_an_arc_leaves_a_line_and_stops_at_the_wall(session):
    session.command(forward=2.0, turn=1.8)
    session.ticks(0.8)
    x, y, theta = place(session.turtle())
    # The speeds last 0.8 s: an arc with a radius of 2 / 1.8.
    assert theta == pytest.approx(1.44, abs=1e-9)
    assert x == pytest.approx(5.544445 + 2 / 1.8 * math.sin(theta), abs=0.03)
    assert y == pytest.approx(5.544445 + 2 / 1.8 * (1 - math.cos(theta)), abs=0.03)
    assert session.sim.board.colour_at(*place(session.turtle())[:1], SIZE - y) == Pen().colour
    session.command(forward=-500.0)
    session.sim.tick()
    session.sim.tick()
    assert session.turtle().y == SIZE


def test_only_a_holonomic_turtle_moves_sideways(session):
    session.command(sideways=1.0)
    session.ticks(0.16)
    assert session.turtle().y == pytest.approx(SIZE / 2, abs=1e-6)
    session.sim.set_parameters([Parameter("holonomic", value=True)])
    session.command(sideways=1.0)
    session.ticks(0.16)
    assert SIZE / 2 - session.turtle().y == pytest.approx(0.16, abs=1e-6)


def test_services_spawn_kill_teleport_clear_and_reset(session):
    spawn = "turtlesim/srv/Spawn"
    assert session.call(spawn, "spawn", x=2.0, y=2.0, theta=0.2).name == "turtle2"
    assert session.call(spawn, "spawn", name="turtle2").name == ""
    assert place(session.turtle("turtle2")) == pytest.approx((2.0, 2.0, 0.2), abs=1e-6)
    session.call("turtlesim/srv/SetPen", "turtle2/set_pen", r=255, width=5)
    session.call(
        "turtlesim/srv/TeleportAbsolute", "turtle2/teleport_absolute", x=4.0, y=2.0, theta=0.0
    )
    session.call("turtlesim/srv/TeleportRelative", "turtle2/teleport_relative", linear=1.0)
    session.sim.tick()
    assert place(session.turtle("turtle2")) == pytest.approx((5.0, 2.0, 0.0), abs=1e-6)
    assert session.sim.board.colour_at(3.0, SIZE - 2.0) == RED
    session.call("turtlesim/srv/SetPen", "turtle2/set_pen", off=1)
    assert not session.turtle("turtle2").pen.is_on
    session.call("std_srvs/srv/Empty", "clear")
    assert session.sim.board.colour_at(3.0, SIZE - 2.0) == WHITE
    session.call("turtlesim/srv/Kill", "kill", name="turtle2")
    session.call("turtlesim/srv/Kill", "kill", name="turtle2")
    assert [*session.sim.turtles] == ["turtle1"]
    session.command(forward=1.0)
    session.sim.tick()
    session.call("std_srvs/srv/Empty", "reset")
    assert place(session.turtle()) == pytest.approx((5.544445, 5.544445, 0.0), abs=1e-6)


def test_a_rotation_ends_at_its_angle_and_another_goal_or_command_aborts_it(session):
    action = get_action("turtlesim/action/RotateAbsolute")
    client: Any = ActionClient(session.user, action, "turtle1/rotate_absolute")
    assert client.wait_for_server(10.0)

    def send(theta: float) -> Any:
        sent = client.send_goal_async(action.Goal(theta=theta))
        session.executor.spin_until_future_complete(sent, 10.0)
        return sent.result().get_result_async()

    def answer(result: Any) -> tuple[int, float]:
        session.executor.spin_until_future_complete(result, 10.0)
        return result.result().status, result.result().result.delta

    first = send(-1.57)
    second = send(1.57)
    aborted, succeeded = 6, 4
    assert answer(first)[0] == aborted
    session.ticks(2.0)
    status, delta = answer(second)
    assert status == succeeded
    assert delta == pytest.approx(-1.57, abs=0.03)
    assert session.turtle().theta == pytest.approx(1.57, abs=0.02)
    third = send(0.0)
    session.command(forward=0.1)
    assert answer(third)[0] == aborted


def test_what_is_not_finite_or_no_name_is_ignored(session):
    session.command(forward=math.nan)
    session.call("turtlesim/srv/TeleportAbsolute", "turtle1/teleport_absolute", x=math.inf)
    assert session.call("turtlesim/srv/Spawn", "spawn", x=math.nan).name == ""
    assert session.call("turtlesim/srv/Spawn", "spawn", name="no name").name == ""
    session.sim.tick()
    assert place(session.turtle()) == pytest.approx((5.544445, 5.544445, 0.0), abs=1e-6)
    assert [*session.sim.turtles] == ["turtle1"]


def test_keys_drive_and_turn_the_turtle_and_another_one_mimics_it(session):
    session.call("turtlesim/srv/Spawn", "spawn", x=2.0, y=2.0, name="turtle2")
    teleop, mimic = TurtleTeleop(), TurtleMimic(cli_args=MIMIC)
    session.add(teleop, mimic)
    reached = 2.0 + 10 * TICK_S
    session.user.create_subscription(
        get_message("geometry_msgs/msg/Twist"), "turtle1/cmd_vel", lambda _: None, 7
    )
    while teleop.count_subscribers("turtle1/cmd_vel") < 2:
        session.executor.spin_once(0.01)
    teleop.on_key("UP")
    while session.turtle("turtle2").x < reached:
        session.sim.tick()
        session.executor.spin_once(0.01)
        if session.turtle().x >= SIZE:
            pytest.fail("the turtle that is followed reached the wall")
    teleop.on_key("r")
    while session.turtle().theta < 1.5:
        session.sim.tick()
        session.executor.spin_once(0.01)
    for node in (teleop, mimic):
        node.destroy_node()


def test_draw_square_goes_two_meters_and_turns_left(session):
    square = DrawSquare()
    corners = []
    pose = get_message("turtlesim/msg/Pose")(x=1.0, y=1.0)
    square._pose = pose
    sent: list[tuple[float, float]] = []
    square._command = lambda linear, angular: sent.append((linear, angular))  # type: ignore[method-assign]
    for x, y, theta in ((1, 1, 0), (1, 1, 0), (3, 1, 0), (3, 1, 0), (3, 1, 0)):
        pose.x, pose.y, pose.theta = float(x), float(y), float(theta)
        square._tick()
        corners.append(square._goal)
    assert corners[0] == pytest.approx((3.0, 1.0, 0.0))
    assert corners[3] == pytest.approx((3.0, 1.0, math.pi / 2))
    assert sent == [(1.0, 0.0), (0.0, 0.0), (0.0, 0.4)]
    square.destroy_node()


@given(strategies.floats(-1e6, 1e6))
def test_an_angle_is_taken_to_half_a_turn_on_either_side(angle):
    normal = normalize_angle(angle)
    assert -math.pi <= normal <= math.pi
    assert math.cos(normal) == pytest.approx(math.cos(angle), abs=1e-6)


def test_a_pen_draws_in_its_width_and_only_while_it_is_on():
    board = Board()
    board.line((1.0, 1.0), (2.0, 1.0), Pen(RED, 9))
    board.line((1.0, 5.0), (2.0, 5.0), Pen(RED, 9, is_on=False))
    assert board.colour_at(1.5, 1.0 + 4 / 45) == RED
    assert board.colour_at(1.5, 1.0 + 6 / 45) == WHITE
    assert board.colour_at(1.5, 5.0) == WHITE
    picture = board.picture(Colour(1, 2, 3))
    assert tuple(picture[0, 0]) == (1, 2, 3)
    assert tuple(picture[90, 135]) == RED


def test_every_turtle_has_a_picture_of_its_own_with_nothing_in_its_corners():
    pictures = [turtle_picture(look) for look in range(LOOKS)]
    assert len({picture.tobytes() for picture in pictures}) == LOOKS
    assert all(picture[0, 0, 3] == 0 and picture[90, 90, 3] == 255 for picture in pictures)
