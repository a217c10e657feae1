"""MoveIt's states, paths and scenes: the robot drawn again, objects where messages put them."""

import math
import time
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer.displays.moveit import planning_scene as scene_request
from teleopctl.viewer.displays.moveit.motion_planning import MotionPlanning
from teleopctl.viewer.displays.moveit.planning_scene import PlanningScene
from teleopctl.viewer.displays.moveit.robot_state import RobotState
from teleopctl.viewer.displays.moveit.trajectory import PlannedPath, TrajectoryDisplay

STRING = get_message("std_msgs/msg/String")
JOINT_STATE = get_message("sensor_msgs/msg/JointState")
JOINT_TRAJECTORY = get_message("trajectory_msgs/msg/JointTrajectory")
POINT = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
SOLID = get_message("shape_msgs/msg/SolidPrimitive")
MESH = get_message("shape_msgs/msg/Mesh")
TRIANGLE = get_message("shape_msgs/msg/MeshTriangle")
POSE = get_message("geometry_msgs/msg/Pose")
CORNER = get_message("geometry_msgs/msg/Point")
HEADER = get_message("std_msgs/msg/Header")
COLOR = get_message("std_msgs/msg/ColorRGBA")

URDF = """
<robot name="arm">
  <link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <link name="upper"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <joint name="mount" type="fixed">
    <parent link="upper"/><child link="slide"/><origin xyz="2 0 0"/>
  </joint>
  <link name="slide"/>
  <joint name="finger" type="prismatic">
    <parent link="slide"/><child link="tip"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="tip"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
</robot>
"""


def made(stage, kind, given=None, *, described=True):
    stage.frames.buffer.set_transform(transform_stamped("world", "base", 1, Transform()))
    stage.frames.update()
    display = kind(stage, "moveit", "/display1", {} if given is None else given)
    display.begin()
    if described:
        stage.publish("/robot_description", STRING(data=URDF))
    return display


def state(held=(), **positions):
    names, values = list(positions), [float(value) for value in positions.values()]
    return SimpleNamespace(
        joint_state=JOINT_STATE(name=names, position=values), attached_collision_objects=held
    )


def path(*states, every_s=1.0, start=None):
    points = []
    for number, positions in enumerate(states):
        point = POINT(positions=[float(value) for value in positions])
        nanoseconds = round(number * every_s * 1e9)
        point.time_from_start.sec, point.time_from_start.nanosec = divmod(nanoseconds, 10**9)
        points.append(point)
    joints = JOINT_TRAJECTORY(joint_names=["shoulder", "finger"], points=points)
    return SimpleNamespace(
        trajectory=[SimpleNamespace(joint_trajectory=joints)], trajectory_start=start or state()
    )


def pose(x=0.0, y=0.0, z=0.0):
    message = POSE()
    message.position.x, message.position.y, message.position.z = x, y, z
    return message


def thing(name, operation=0, frame="world", at=(0.0, 0.0, 0.0), database="", **shapes):
    kinds = ("primitives", "primitive_poses", "meshes", "mesh_poses", "planes", "plane_poses")
    return SimpleNamespace(
        id=name,
        header=HEADER(frame_id=frame),
        pose=pose(*at),
        operation=bytes([operation]),
        type=SimpleNamespace(key="", db=database),
        **{kind: shapes.get(kind, []) for kind in kinds},
    )


def box(name, *, at=(0.0, 0.0, 0.0), **fields):
    solid = SOLID(type=SOLID.BOX, dimensions=[1.0, 2.0, 3.0])
    return thing(name, at=at, primitives=[solid], primitive_poses=[pose()], **fields)


def scene(*objects, diff=False, robot=None, colors=(), octomap=()):
    return SimpleNamespace(
        is_diff=diff,
        robot_state=robot or state(),
        object_colors=colors,
        world=SimpleNamespace(
            collision_objects=objects,
            octomap=SimpleNamespace(octomap=SimpleNamespace(data=octomap)),
        ),
    )


def node(stage, name):
    return stage.scene._handle_from_node_name.get(name)


def stands(ghost, link):
    """Where a link stands in the ghost's root, as browsers have it."""
    found = ghost._links[link]
    return [float(part) for part in (*found.position, *found.wxyz)]


def solids(display, stage, shape="box", frame="world"):
    display.tick()
    above = f"/frames/{frame}/display1/{shape}"
    found = node(stage, f"{above}_clear") or node(stage, above)
    return np.empty((0, 3)) if found is None else np.round(found.batched_positions, 3)


def test_the_state_is_reached_by_the_robots_own_kinematics(stage):
    display = made(stage, RobotState)
    message = SimpleNamespace(state=state(shoulder=math.pi / 2, finger=0.5), hide=False)
    stage.publish("/display_robot_state", message)
    ghost = display._overlay
    assert ghost._root.name == "/frames/base/display1_state"
    half = math.sqrt(0.5)
    assert stands(ghost, "upper") == pytest.approx([0, 0, 1, half, 0, 0, half], abs=1e-6)
    assert stands(ghost, "tip")[:3] == pytest.approx([0, 2.5, 1], abs=1e-6)
    message.hide = True
    stage.publish("/display_robot_state", message)
    assert not ghost._root.visible
    display.end()
    assert node(stage, "/frames/base/display1_state") is None


def test_a_state_that_comes_before_the_description_is_drawn_with_it(stage):
    display = made(stage, RobotState, described=False)
    stage.publish("/display_robot_state", SimpleNamespace(state=state(shoulder=1.0)))
    assert display.status == ("warn", "No message received on /robot_description yet")
    stage.publish("/robot_description", STRING(data=URDF))
    assert display._overlay is not None
    assert display.status[0] == "ok"
    stage.publish("/robot_description", STRING(data="<nothing/>"))
    assert display.status[0] == "error"
    assert display._overlay is not None


def test_topics_and_properties_stand_where_moveits_files_have_them(stage):
    given = {"Robot State Topic": "/states", "Robot Alpha": 0.25}
    display = made(stage, RobotState, given)
    assert display.topic == "/states"
    assert display.values.number("Robot Alpha") == 0.25
    display.set_topic("/others")
    assert given["Robot State Topic"] == "/others"
    assert given["Class"] == "moveit_rviz_plugin/RobotState"
    planned = {"Planned Path": {"Trajectory Topic": "/plan", "Loop Animation": True}}
    planning = made(stage, MotionPlanning, planned)
    assert stage.listens_to("/plan")
    assert stage.listens_to("/monitored_planning_scene")
    planning.end()
    assert not stage.listens_to("/plan")


@pytest.mark.parametrize(
    ("display_time", "duration", "half_way"),
    [("3x", 1.0, 1.5), ("REALTIME", 3.0, 1.5), ("0.5 s", 2.0, 2.0), ("soon", 0.2, 2.0)],
)
def test_a_path_is_played_as_fast_as_the_property_says(display_time, duration, half_way):
    played = PlannedPath.from_message(path((0, 0), (1, 0), (2, 0), (3, 0)))
    assert played.duration(display_time) == pytest.approx(duration)
    assert played.at(duration / 2, display_time)["shoulder"] == pytest.approx(half_way)
    assert played.at(duration, display_time)["shoulder"] == 3.0


def test_a_path_without_times_is_played_all_the_same():
    played = PlannedPath.from_message(path((0, 0), (1, 0), every_s=0.0))
    assert played.duration("3x") > 0.0
    assert played.at(played.duration("3x"), "3x")["shoulder"] == 1.0


def test_a_planned_path_is_played_once_and_a_loop_begins_anew(stage):
    display = made(stage, TrajectoryDisplay)
    stage.publish("/display_planned_path", path((0, 0), (1, 0), start=state(finger=0.5)))
    display.tick()
    ghost = display._overlay
    assert ghost._root.visible
    display._began = time.monotonic() - 0.3
    display.tick()
    assert 0.8 < 2 * math.asin(stands(ghost, "upper")[6]) < 1.0
    display._began -= 10.0
    display.tick()
    assert not ghost._root.visible
    display.set("Loop Animation", True)
    stage.publish("/display_planned_path", path((0, 0), (1, 0)))
    for _ in range(3):
        display._began -= 10.0
        display.tick()
    display.tick()
    assert display._overlay._root.visible


def test_the_next_path_waits_for_the_end_of_the_one_that_is_played(stage):
    display = made(stage, TrajectoryDisplay)
    stage.publish("/display_planned_path", path((0, 0), (1, 0)))
    stage.publish("/display_planned_path", path((0, 0), (2, 0)))
    display.tick()
    assert display._path.states[-1]["shoulder"] == 1.0
    display._began -= 10.0
    display.tick()
    assert display._path.states[-1]["shoulder"] == 2.0


def test_a_trail_shows_the_states_on_the_way_but_never_too_many(stage):
    display = made(stage, TrajectoryDisplay, {"Show Trail": True})
    stage.publish("/display_planned_path", path((0, 0), (1, 0), (2, 0)))
    assert len(display._trail) == 3
    stage.publish("/robot_description", STRING(data=URDF))
    assert len(display._trail) == 3
    display._playing = False
    stage.publish("/display_planned_path", path(*[(0, 0)] * 300))
    assert len(display._trail) <= 20
    display.end()
    assert not [name for name in stage.scene._handle_from_node_name if "trail" in name]


def test_objects_are_added_moved_and_removed(stage):
    display = made(stage, PlanningScene)
    topic = "/monitored_planning_scene"
    stage.publish(topic, scene(box("a", at=(1.0, 0, 0)), box("b", at=(2.0, 0, 0))))
    assert solids(display, stage).tolist() == [[1, 0, 0], [2, 0, 0]]
    assert display.status == ("ok", "2 objects")
    stage.publish(topic, scene(thing("a", 3, at=(5.0, 0, 0)), diff=True))
    assert solids(display, stage).tolist() == [[5, 0, 0], [2, 0, 0]]
    extra = SOLID(type=SOLID.BOX, dimensions=[1.0, 1.0, 1.0])
    more = thing("b", 2, primitives=[extra], primitive_poses=[pose(0, 7, 0)])
    stage.publish(topic, scene(more, diff=True))
    assert solids(display, stage).tolist() == [[5, 0, 0], [2, 0, 0], [2, 7, 0]]
    stage.publish(topic, scene(thing("b", 1), diff=True))
    assert solids(display, stage).tolist() == [[5, 0, 0]]
    stage.publish(topic, scene(box("c")))
    assert solids(display, stage).tolist() == [[0, 0, 0]]
    display.end()
    assert not len(solids(display, stage))


def test_every_shape_has_its_size(stage):
    display = made(stage, PlanningScene)
    corners = [CORNER(x=x, y=y) for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))]
    mesh = MESH(vertices=corners, triangles=[TRIANGLE(vertex_indices=[0, 1, 2])])
    shapes = thing(
        "all",
        primitives=[
            SOLID(type=SOLID.SPHERE, dimensions=[2.0]),
            SOLID(type=SOLID.CYLINDER, dimensions=[3.0, 0.5]),
            SOLID(type=SOLID.CONE, dimensions=[3.0, 0.5]),
        ],
        primitive_poses=[pose(), pose(), pose()],
        meshes=[mesh],
        mesh_poses=[pose()],
    )
    stage.publish("/monitored_planning_scene", scene(shapes))
    display.tick()
    above = "/frames/world/display1"
    sizes = {
        name: node(stage, f"{above}/{name}_clear").batched_scales[0].tolist()
        for name in ("sphere", "cylinder", "cone")
    }
    assert sizes == {"sphere": [4, 4, 4], "cylinder": [1, 1, 3], "cone": [1, 1, 3]}
    drawn = [
        found.vertices.tolist()
        for name, found in stage.scene._handle_from_node_name.items()
        if name.startswith(f"{above}/mesh_")
    ]
    assert drawn == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def test_an_object_has_its_own_colour_or_the_scenes(stage):
    display = made(stage, PlanningScene, {"Scene Geometry": {"Scene Alpha": 1.0}})
    painted = SimpleNamespace(id="a", color=COLOR(r=1.0, a=1.0))
    stage.publish("/monitored_planning_scene", scene(box("a"), box("b"), colors=[painted]))
    display.tick()
    colors = node(stage, "/frames/world/display1/box").batched_colors.tolist()
    assert colors[0] == [255, 0, 0]
    red, green, blue = colors[1]
    assert green > 4 * max(red, blue)


def test_what_the_robot_holds_moves_with_its_link_until_it_is_let_go(stage):
    display = made(stage, PlanningScene)
    topic = "/monitored_planning_scene"
    stage.publish(topic, scene(box("cup")))
    held = SimpleNamespace(object=box("cup", frame="tip"), link_name="tip")
    stage.publish(topic, scene(thing("cup", 1), diff=True, robot=state([held])))
    assert len(solids(display, stage, frame="tip")) == 1
    assert not len(solids(display, stage))
    gone = SimpleNamespace(object=thing("cup", 1), link_name="tip")
    stage.publish(topic, scene(box("cup"), diff=True, robot=state([gone])))
    assert len(solids(display, stage)) == 1
    assert not len(solids(display, stage, frame="tip"))


def test_the_scenes_robot_stands_as_moveit_knows_it(stage):
    display = made(stage, PlanningScene)
    stage.publish("/monitored_planning_scene", scene(robot=state(finger=1.0)))
    assert stands(display._robot, "tip")[:3] == pytest.approx([3, 0, 1])
    display.set("Scene Robot/Show Robot Visual", False)
    assert display._robot is None


def test_the_whole_scene_is_asked_for_until_it_is_there(stage, monkeypatch):
    asked: list[int] = []
    destroyed: list[object] = []

    class Client:
        answer: Future[object]

        def call_async(self, request):
            asked.append(request.components.components)
            self.answer = Future()
            return self.answer

    client = Client()
    stage.node.create_client = lambda kind, service: client
    stage.node.destroy_client = destroyed.append
    request = SimpleNamespace(components=SimpleNamespace(components=0))
    kind = SimpleNamespace(Request=lambda: request)
    monkeypatch.setattr(scene_request, "get_service", lambda name: kind)
    display = made(stage, PlanningScene, {"Move Group Namespace": "left"})
    display.tick()
    assert not asked
    stage.node.topics["/left/get_planning_scene"] = ["moveit_msgs/srv/GetPlanningScene"]
    for _ in range(2):
        display._request._due = 0.0
        display.tick()
    assert len(asked) == 2
    client.answer.set_result(SimpleNamespace(scene=scene(box("a"))))
    assert len(solids(display, stage)) == 1
    display._request._due = 0.0
    display.tick()
    assert len(asked) == len(destroyed) == 2


def test_what_cannot_be_drawn_of_a_scene_is_told(stage):
    display = made(stage, PlanningScene)
    odd = thing(
        "odd",
        primitives=[SOLID(type=9), SOLID(type=SOLID.BOX, dimensions=[1.0, math.nan, 1.0])],
        primitive_poses=[pose(), pose()],
        meshes=[MESH(triangles=[TRIANGLE(vertex_indices=[0, 1, 2])])],
        mesh_poses=[pose()],
    )
    stage.publish("/monitored_planning_scene", scene(odd, octomap=[1, 2]))
    display.tick()
    assert display.status == (
        "warn",
        "1 object; 3 shapes cannot be drawn and its octomap is not drawn",
    )


def test_the_goal_stands_where_the_planned_path_ends(stage):
    display = made(stage, MotionPlanning)
    stage.publish("/display_planned_path", path((0, 0), (0, 1)))
    display.tick()
    assert stands(display._goal, "tip")[:3] == pytest.approx([3, 0, 1])
    assert display._planned._overlay._root.visible
    display.set("Planning Request/Query Goal State", False)
    assert display._goal is None
    display.set("Planned Path/Robot Alpha", 0.25)
    assert display._planned.values.number("Robot Alpha") == 0.25
    display.end()
    left = [name for name in stage.scene._handle_from_node_name if "display1_" in name]
    assert not left


def test_links_of_the_goal_that_stand_where_the_robot_does_are_not_drawn_twice(stage):
    display = made(stage, MotionPlanning)
    stage.publish("/monitored_planning_scene", scene(robot=state(shoulder=1.0)))
    stage.publish("/display_planned_path", path((1, 0), (1, 1)))
    display.tick()
    visible = {name: link.visible for name, link in display._goal._links.items()}
    assert visible == {"base": False, "upper": False, "tip": True}
    stage.publish("/monitored_planning_scene", scene(diff=True, robot=state(shoulder=0.0)))
    display.tick()
    assert display._goal._links["upper"].visible
    # Without the scene's robot, those that stand where tf has them.
    display.set("Scene Robot/Show Robot Visual", False)
    display.tick()
    visible = {name: link.visible for name, link in display._goal._links.items()}
    assert visible == {"base": False, "upper": True, "tip": True}


def test_the_goal_is_drawn_until_the_robot_has_reached_it(stage):
    display = made(stage, MotionPlanning, {"Scene Robot": {"Show Robot Visual": False}})
    stage.publish("/display_planned_path", path((0, 0), (0, 1), every_s=0.001))

    def moved_to(finger):
        poses = display.model.poses({"finger": finger})
        for name, pose in list(poses.items())[1:]:
            stage.frames.buffer.set_transform(transform_stamped("base", name, 2, pose))
        stage.frames.update()
        display._planned._playing = False
        display.tick()

    display.tick()
    moved_to(0.5)
    assert display._goal is not None
    moved_to(0.995)
    assert display._goal is None
    moved_to(0.0)
    assert display._goal is None
    stage.publish("/display_planned_path", path((0, 0), (0, 1)))
    display.tick()
    assert display._goal is not None


def test_bodies_of_the_simulation_may_be_left_to_the_display_of_its_world(stage):
    display = made(stage, PlanningScene)
    simulated = box("table", database="mujoco_sim")
    stage.publish("/monitored_planning_scene", scene(simulated, box("a", at=(1.0, 0, 0))))
    assert len(solids(display, stage)) == 2
    display.set("Scene Geometry/Show Simulated World", False)
    assert solids(display, stage).tolist() == [[1, 0, 0]]


def test_meshes_are_found_beside_the_description_as_those_of_the_robot_are(stage, tmp_path):
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    stage.robot_folder = tmp_path
    display = made(stage, RobotState, described=False)
    shape = '<visual><geometry><mesh filename="part.obj"/></geometry></visual>'
    urdf = f'<robot name="r"><link name="base">{shape}</link></robot>'
    stage.publish("/robot_description", STRING(data=urdf))
    assert display.status[0] == "ok"
    assert set(display.model.parts.meshes) == {"part.obj"}


numbers = strategies.floats(width=32)
stamps = strategies.integers(-(2**31), 2**31 - 1)


@given(
    strategies.lists(
        strategies.tuples(strategies.lists(numbers, max_size=3), stamps), min_size=1, max_size=4
    ),
    strategies.sampled_from(["3x", "0.05 s", "REALTIME", "0x", "-1 s", ""]),
    strategies.floats(0.0, 100.0),
)
def test_an_absurd_path_has_a_state_at_any_time(points, display_time, elapsed):
    message = path(*[positions for positions, _ in points])
    for point, (_, stamp) in zip(
        message.trajectory[0].joint_trajectory.points, points, strict=True
    ):
        point.time_from_start.sec = stamp
    played = PlannedPath.from_message(message)
    assert played.duration(display_time) >= 0.0
    found = played.at(elapsed, display_time)
    assert all(math.isfinite(value) for value in found.values())
