"""The standard services of simulators, by the definitions that every ROS 2 program has."""

from __future__ import annotations

import json
import os
import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionClient, Parameter, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.testing import LONGEST_WAIT_S, RosGraph
from tests.system.sim_partner import Partner, command, stamp_ns, teleop_urdf

TABLE = package_share("teleopctl") / "worlds" / "table.urdf"
INERTIA = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
CAN = f"""<robot name="can"><link name="can">
  <inertial><mass value="0.2"/>{INERTIA}</inertial>
  <collision><geometry><cylinder radius="0.05" length="0.1"/></geometry></collision>
</link></robot>"""
MESH = CAN.replace('<cylinder radius="0.05" length="0.1"/>', '<mesh filename="{}"/>')
BALL = """<mujoco model="yard"><worldbody><body name="ball" pos="1 1 1">
  <freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""
BOX = "things: {box: {shape: box, size: [0.1, 0.1, 0.1], mass: 0.2}}"
BOMB = '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {chr(98 + n)} "{10 * f"&{chr(97 + n)};"}">' for n in range(20)
)
BOMB += "]><robot name='&u;'><link name='a'/></robot>"

Result = get_message("simulation_interfaces/msg/Result")
State = get_message("simulation_interfaces/msg/SimulationState")
SpawnEntity = get_service("simulation_interfaces/srv/SpawnEntity")
LoadWorld = get_service("simulation_interfaces/srv/LoadWorld")
SetEntityState = get_service("simulation_interfaces/srv/SetEntityState")
SetState = get_service("simulation_interfaces/srv/SetSimulationState")
SimulateSteps = get_action("simulation_interfaces/action/SimulateSteps")


class Caller(Partner):
    """Calls the standard services."""

    def ask(self, service: str, where: str, /, **request: Any) -> Any:
        kind = get_service(f"simulation_interfaces/srv/{service}")
        client = self.create_client(kind, f"/{where}")
        assert client.wait_for_service(LONGEST_WAIT_S)
        return client.call(kind.Request(**request), timeout_sec=LONGEST_WAIT_S)

    def do(self, service: str, where: str, /, **request: Any) -> Any:
        """Ask, and see that it is done."""
        response = self.ask(service, where, **request)
        assert response.result.result == Result.RESULT_OK, response.result.error_message
        return response

    def spawn(self, text: str, x: float, **request: Any) -> Any:
        kind = SpawnEntity.Request(resource_string=text, **request)
        kind.initial_pose.pose.position.x, kind.initial_pose.pose.position.z = x, 1.0
        fields = {name: getattr(kind, name) for name in kind.get_fields_and_field_types()}
        return self.ask("SpawnEntity", "spawn_entity", **fields)

    def names(self, **filters: Any) -> list[str]:
        wanted = get_message("simulation_interfaces/msg/EntityFilters")(**filters)
        return list(self.do("GetEntities", "get_entities", filters=wanted).entities)

    def height(self, entity: str) -> float:
        state = self.do("GetEntityState", "get_entity_state", entity=entity).state
        return float(state.pose.position.z)

    def step(self, count: int) -> None:
        self.do("StepSimulation", "step_simulation", steps=count)

    def state(self) -> int:
        return int(self.do("GetSimulationState", "get_simulation_state").state.state)


@pytest.fixture(scope="module")
def caller(shared_ros: RosGraph) -> Iterator[Caller]:
    """Beside a simulator that stands still at its start, with the arm and its table."""
    partner = Caller(teleop_urdf())
    flags = ["-p", f"world:={TABLE}", "-p", "paused:=true", "-p", "real_time_factor:=0"]
    sim = shared_ros.spawn_module(
        "teleopctl.nodes", ["mujoco_sim", "mujoco_sim", "--ros-args", *flags]
    )
    sim.wait_for_line("Simulation is paused")
    partner.connect(lambda state: command(state, joint_1=0.5))
    yield partner
    partner.close()


@pytest.fixture(autouse=True)
def _from_the_start(caller: Caller) -> None:
    caller.ask("SetSimulationState", "set_simulation_state", state=State(state=State.STATE_STOPPED))
    caller.do("ResetSimulation", "reset_simulation")  # it may have been stopped already


def test_what_is_there_is_told_by_name_kind_and_place(caller: Caller) -> None:
    assert caller.names() == ["teleop", "table", "cube"]
    assert caller.names(filter="^t") == ["teleop", "table"]
    category = get_message("simulation_interfaces/msg/EntityCategory")
    moving = category(category=category.CATEGORY_DYNAMIC_OBJECT)
    assert caller.names(categories=[moving]) == ["cube"]
    bounds = caller.do("GetEntityBounds", "get_entity_bounds", entity="cube").bounds
    high, low = bounds.points
    assert (high.x, low.x) == pytest.approx((0.05, -0.05))
    point = get_message("geometry_msgs/msg/Vector3")
    around = type(bounds)(
        type=bounds.TYPE_SPHERE, points=[point(x=-0.15, y=1.5, z=0.17), point(x=0.03)]
    )
    assert caller.names(bounds=around) == ["cube"]
    missing = caller.ask("GetEntityState", "get_entity_state", entity="chair").result
    assert missing.result == Result.RESULT_NOT_FOUND
    assert missing.error_message == "There is no entity 'chair'; there is teleop, table, cube"


def test_things_are_spawned_fall_and_are_deleted(caller: Caller) -> None:
    assert caller.spawn(CAN, 2.0).entity_name == "can"
    taken = caller.spawn(CAN, 2.0).result
    assert taken.result == SpawnEntity.Response.NAME_NOT_UNIQUE
    assert caller.spawn(CAN, 2.5, allow_renaming=True).entity_name == "can_1"
    assert caller.spawn(BOX, 3.0).entity_name == "box"
    info = get_message("simulation_interfaces/msg/EntityInfo")(tags=["mine"])
    caller.do("SetEntityInfo", "set_entity_info", entity="box", info=info)
    caller.step(1000)
    assert caller.height("box") == pytest.approx(0.05, abs=2e-3)
    caller.do("DeleteEntity", "delete_entity", entity="box")
    caller.spawn(BOX, 3.0)
    assert caller.do("GetEntityInfo", "get_entity_info", entity="box").info.tags == []
    caller.do("DeleteEntity", "delete_entity", entity="box")
    assert caller.height("can") == pytest.approx(0.05, abs=2e-3)
    caller.do("DeleteEntity", "delete_entity", entity="can")
    assert caller.names() == ["teleop", "table", "cube", "can_1"]
    assert caller.height("can_1") == pytest.approx(0.05, abs=2e-3)
    kept = caller.ask("DeleteEntity", "delete_entity", entity="teleop").result
    assert kept.result == Result.RESULT_OPERATION_FAILED


def test_what_is_spawned_is_on_the_topics_of_what_moves(caller: Caller) -> None:
    seen: list[list[str]] = []
    kind = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
    caller.create_subscription(
        kind,
        "/mujoco_sim/free_joint_states",
        lambda message: seen.append([state.name for state in message.free_joints]),
        10,
        immediate=True,
    )
    caller.spawn(CAN, 2.0)
    while ["cube", "can"] not in seen:  # until the simulator has seen who listens
        caller.step(100)


@pytest.mark.parametrize(
    ("text", "x", "code"),
    [
        (CAN, float("nan"), SpawnEntity.Response.INVALID_POSE),
        (CAN, 1e300, SpawnEntity.Response.INVALID_POSE),
        ("", 1.0, SpawnEntity.Response.NO_RESOURCE),
        ("<robot", 1.0, SpawnEntity.Response.RESOURCE_PARSE_ERROR),
        ("<house/>", 1.0, SpawnEntity.Response.UNSUPPORTED_FORMAT),
        (BOMB, 1.0, SpawnEntity.Response.RESOURCE_PARSE_ERROR),
        (CAN.replace('"0.2"', '"-1"'), 1.0, SpawnEntity.Response.RESOURCE_PARSE_ERROR),
        (BOX.replace("0.2", ".inf"), 1.0, SpawnEntity.Response.RESOURCE_PARSE_ERROR),
        (MESH.format("/none.stl"), 1.0, SpawnEntity.Response.MISSING_ASSETS),
    ],
)
def test_what_makes_no_sense_is_refused_in_words(
    caller: Caller, text: str, x: float, code: int
) -> None:
    result = caller.spawn(text, x, name="thing").result
    assert (result.result, bool(result.error_message)) == (code, True)
    assert caller.names() == ["teleop", "table", "cube"]


def test_entities_are_put_where_they_are_to_be(caller: Caller) -> None:
    state = get_message("simulation_interfaces/msg/EntityState")()
    state.pose.position.z, state.twist.linear.x = 2.0, 1.0
    caller.do("SetEntityState", "set_entity_state", entity="cube", state=state)
    caller.step(100)
    found = caller.do("GetEntityState", "get_entity_state", entity="cube").state
    assert found.pose.position.x == pytest.approx(0.1)
    assert found.pose.position.z == pytest.approx(2.0 - 9.81 * 0.1 * 0.101 / 2.0)
    assert found.acceleration.linear.z == pytest.approx(-9.81)
    state.pose.orientation.w = 0.0
    refused = caller.ask("SetEntityState", "set_entity_state", entity="cube", state=state).result
    assert refused.result == SetEntityState.Response.INVALID_POSE


def test_what_stands_is_shown_elsewhere_until_a_reset(caller: Caller) -> None:
    kind, seen = get_message("visualization_msgs/msg/MarkerArray"), queue.Queue[float]()

    def note(message: Any) -> None:
        for marker in message.markers:
            if marker.ns == "table":
                seen.put(marker.pose.position.x)

    shown = caller.create_subscription(kind, "/mujoco_sim/world_markers", note, qos_profile_latched)

    def wait_for(x: float) -> None:
        while seen.get(timeout=LONGEST_WAIT_S) != pytest.approx(x):
            pass

    first = seen.get(timeout=LONGEST_WAIT_S)
    state = caller.do("GetEntityState", "get_entity_state", entity="table").state
    state.pose.position.x += 3.0
    caller.do("SetEntityState", "set_entity_state", entity="table", state=state)
    wait_for(first + 3.0)
    caller.do("ResetSimulation", "reset_simulation")
    wait_for(first)
    caller.destroy_subscription(shown)


def test_links_are_pushed(caller: Caller) -> None:
    wrench = get_message("mujoco_ros2_control_msgs/msg/ExternalWrench")()
    wrench.wrench.header.frame_id, wrench.wrench.wrench.force.z = "cube", 10.0
    wrench.duration.nanosec = 100_000_000
    several = get_message("mujoco_ros2_control_msgs/msg/ExternalWrenchArray")
    every = several(external_wrenches=[wrench])
    assert caller.call("ApplyExternalWrench", "apply_wrench", wrenches=every).success
    caller.step(100)
    assert caller.height("cube") > 0.3
    wrench.wrench.header.frame_id = "chair"
    refused = caller.call("ApplyExternalWrench", "apply_wrench", wrenches=every)
    assert (refused.success, "'chair'" in refused.message) == (False, True)


def test_the_simulation_is_played_paused_and_stopped(caller: Caller) -> None:
    assert caller.state() == State.STATE_STOPPED
    for wanted in (State.STATE_PLAYING, State.STATE_PAUSED):
        caller.do("SetSimulationState", "set_simulation_state", state=State(state=wanted))
        assert caller.state() == wanted
    again = caller.ask(
        "SetSimulationState", "set_simulation_state", state=State(state=State.STATE_PAUSED)
    ).result
    assert again.result == SetState.Response.ALREADY_IN_TARGET_STATE


def test_a_reset_takes_back_what_its_scope_says(caller: Caller) -> None:
    scopes = get_service("simulation_interfaces/srv/ResetSimulation").Request
    caller.spawn(CAN, 2.0)
    caller.step(500)

    def now() -> int:
        found = caller.do("GetEntityState", "get_entity_state", entity="teleop").state
        return int(found.header.stamp.nanosec)

    caller.do("ResetSimulation", "reset_simulation", scope=scopes.SCOPE_STATE)
    assert (caller.height("can"), now()) == (1.0, 500_000_000)
    caller.do("ResetSimulation", "reset_simulation", scope=scopes.SCOPE_TIME)
    assert now() == 0
    caller.do("ResetSimulation", "reset_simulation", scope=scopes.SCOPE_SPAWNED)
    assert caller.names() == ["teleop", "table", "cube"]
    caller.step(200)
    assert now() == 200_000_000


def test_all_is_back_after_a_full_reset_as_if_it_were_launched_again(caller: Caller) -> None:
    before = str(caller.do("GetEntitiesStates", "get_entities_states").states)
    caller.spawn(CAN, 2.0)
    caller.do("DeleteEntity", "delete_entity", entity="cube")
    caller.spawn(CAN, 2.0, name="cube")
    caller.step(100)
    spawned = get_service("simulation_interfaces/srv/ResetSimulation").Request.SCOPE_SPAWNED
    caller.do("ResetSimulation", "reset_simulation", scope=spawned)
    assert caller.names() == ["teleop", "table"]

    caller.do("ResetSimulation", "reset_simulation")
    assert caller.names() == ["teleop", "table", "cube"]
    assert str(caller.do("GetEntitiesStates", "get_entities_states").states) == before
    caller.do("DeleteEntity", "delete_entity", entity="table")
    caller.step(10)
    caller.do("SetSimulationState", "set_simulation_state", state=State(state=State.STATE_STOPPED))
    assert caller.names() == ["teleop", "table", "cube"]


def test_steps_are_an_action_that_tells_of_each(caller: Caller) -> None:
    client = ActionClient(caller, SimulateSteps, "/simulate_steps")
    assert client.wait_for_server(LONGEST_WAIT_S)
    told: list[int] = []
    while 3 not in told:  # until the simulator has seen who listens
        answer = client.send_goal(
            SimulateSteps.Goal(steps=3),
            feedback_callback=lambda message: told.append(message.feedback.completed_steps),
        )
        assert answer is not None
        assert answer.result.result.result == Result.RESULT_OK
    now = caller.do("GetEntityState", "get_entity_state", entity="teleop").state.header.stamp
    assert now.nanosec % 3_000_000 == 0
    assert now.nanosec > 0
    client.destroy()


def test_others_are_answered_while_it_steps_and_pausing_ends_the_steps(caller: Caller) -> None:
    kind = get_service("simulation_interfaces/srv/StepSimulation")
    caller.step(1)  # it is there
    steps = caller.create_client(kind, "/step_simulation").call_async(kind.Request(steps=10**18))
    assert caller.height("cube") > 0.0
    caller.do("SetSimulationState", "set_simulation_state", state=State(state=State.STATE_PAUSED))
    answer: Any = steps.wait_for_response(LONGEST_WAIT_S)
    assert "The steps were ended" in answer.result.error_message


def test_no_request_ends_the_simulator(caller: Caller, tmp_path: Path) -> None:
    """Nor does one write over what is no file: answered in words, one after the other."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (str(pipe), "/a\0b", f"/{'a' * 300}", "/etc/passwd/x", "~nobody.of.that.name/x"):
        for service in ("save_world", "reset_world"):
            answer = caller.call("ResetWorld", service, keyframe=path)
            assert (answer.success, bool(answer.message)) == (False, True)
        spawned = caller.ask("SpawnEntity", "spawn_entity", uri=path)
        assert spawned.result.result == Result.RESULT_NOT_FOUND
    assert pipe.is_fifo()
    unknown = caller.ask("ResetSimulation", "reset_simulation", scope=8)
    assert unknown.result.result == Result.RESULT_FEATURE_UNSUPPORTED
    assert caller.names(filter="^[[:lower:]]{6}$") == ["teleop"]


def test_models_come_by_gazebos_uris_and_by_their_folders(caller: Caller, tmp_path: Path) -> None:
    cup = tmp_path / "cup"
    cup.mkdir()
    (cup / "model.config").write_text("<model><sdf version='1.9'>cup.sdf</sdf></model>")
    shape = "<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry>"
    (cup / "cup.sdf").write_text(
        f"<sdf version='1.9'><model name='cup'><link name='l'>{shape}</collision></link></model>"
        "</sdf>"
    )
    for uri, name in ((str(cup), "cup"), ("model://teleopctl/worlds/table.urdf", "furniture")):
        caller.do("SpawnEntity", "spawn_entity", uri=uri, name=name)
    assert {"cup", "furniture/table"} <= set(caller.names())
    caller.do("LoadWorld", "load_world", uri="model://teleopctl/worlds/table.urdf")
    assert caller.names() == ["teleop", "table", "cube"]
    for uri in ("model://no_such_model", "https://fuel.gazebosim.org/1.0/Open/models/Coke"):
        refused = caller.ask("SpawnEntity", "spawn_entity", uri=uri).result
        assert refused.result == Result.RESULT_NOT_FOUND
        assert "GZ_SIM_RESOURCE_PATH" in refused.error_message


def test_what_is_refused_is_told_in_few_words_however_long_it_is(caller: Caller) -> None:
    box = "{shape: box, size: [0.1, 0.1, 0.1], mass: 0.2, at: [9, 0, %d]}"
    things = ", ".join(f"b{n}: {box % n}" for n in range(40))
    caller.do("SpawnEntity", "spawn_entity", name="pile", resource_string=f"things: {{{things}}}")
    long = "n" * 1_000_000
    named = caller.ask("SpawnEntity", "spawn_entity", name=long, resource_string=CAN).result
    missed = caller.ask("DeleteEntity", "delete_entity", entity=long).result
    assert named.result == SpawnEntity.Response.NAME_INVALID
    assert missed.result == Result.RESULT_NOT_FOUND
    for refused in (named, missed):
        assert len(refused.error_message) < 1000
    assert missed.error_message.endswith(" and 13 more")


def test_many_that_are_spawned_at_once_are_there_each_as_it_asked(caller: Caller) -> None:
    one = get_message("simulation_interfaces/msg/SpawnEntity")
    resource = get_message("simulation_interfaces/msg/Resource")
    can, empty = resource(resource_string=CAN), resource(resource_string="<mujoco/>")
    requests = [one(name=f"can{n}", entity_resource=can) for n in range(12)]
    for n, each in enumerate(requests):
        each.initial_pose.pose.position.x, each.initial_pose.pose.position.z = 5.0 + n, 1.0
    requests += [
        one(name="can3", entity_resource=can),
        one(name="can4", entity_resource=can, allow_renaming=True),
        one(name="none", entity_resource=empty),
    ]
    many = caller.ask("SpawnEntities", "spawn_entities", spawn_requests=requests)
    codes = [each.result.result for each in many.results]
    assert codes == [
        *(12 * [Result.RESULT_OK]),
        SpawnEntity.Response.NAME_NOT_UNIQUE,
        Result.RESULT_OK,
        SpawnEntity.Response.RESOURCE_PARSE_ERROR,
    ]
    assert many.results[13].entity_name == "can4_1"
    names = [f"can{n}" for n in range(12)]
    assert sorted(caller.names(filter="^can")) == sorted([*names, "can4_1"])
    state = caller.do("GetEntityState", "get_entity_state", entity="can7").state
    assert state.pose.position.x == pytest.approx(12.0)


def test_a_filter_that_takes_for_ever_holds_nothing_up(caller: Caller) -> None:
    """Time goes on and other services answer; whoever asked is told."""
    assert caller.names(filter="^(t(e|a)+[a-z]*)+$") == ["teleop", "table"]
    filters = get_message("simulation_interfaces/msg/EntityFilters")
    kind = get_service("simulation_interfaces/srv/GetEntities")
    client = caller.create_client(kind, "/get_entities")
    assert caller.spawn(CAN, 2.0, name="a" * 60 + "-").entity_name
    endless = client.call_async(kind.Request(filters=filters(filter="^(a|a)*(a+)+$")))
    caller.step(10)
    assert caller.names(filter="^cube$") == ["cube"]
    assert not endless.done()
    refused: Any = endless.wait_for_response(LONGEST_WAIT_S)
    assert refused.result.result == Result.RESULT_OPERATION_FAILED
    assert "it takes longer than" in refused.result.error_message
    for wrong in ("(", "((((a)", "a" * 20_000, "[[:alpha:]"):
        assert caller.ask(
            "GetEntities", "get_entities", filters=filters(filter=wrong)
        ).result.result


def test_places_with_names_come_with_a_world_and_what_can_be_spawned_is_listed(
    caller: Caller, tmp_path: Path
) -> None:
    text = """
things: {shelf: {shape: box, size: [1, 1, 1]}}
poses:
  dock: {at: [1, 2, 0], rpy: [0, 0, 3.14159265], tags: [goal, spawn], size: [1, 1, 2]}
  gate: {at: [5, 0, 0], description: the way out}"""
    caller.do("LoadWorld", "load_world", uri=str(TABLE))
    assert not caller.do("GetNamedPoses", "get_named_poses").poses
    caller.do("LoadWorld", "load_world", resource_string=text)
    dock, gate = caller.do("GetNamedPoses", "get_named_poses").poses
    assert (dock.pose.position.y, dock.pose.orientation.z) == pytest.approx((2.0, 1.0))
    assert (gate.name, gate.description, dock.tags) == ("gate", "the way out", ["goal", "spawn"])
    tags = get_message("simulation_interfaces/msg/TagsFilter")(tags=["goal"])
    assert len(caller.do("GetNamedPoses", "get_named_poses", tags=tags).poses) == 1
    bounds = caller.do("GetNamedPoseBounds", "get_named_pose_bounds", name="dock").bounds
    assert [(point.x, point.z) for point in bounds.points] == [(0.5, 1.0), (-0.5, -1.0)]
    assert not caller.do("GetNamedPoseBounds", "get_named_pose_bounds", name="gate").bounds.points
    lost = caller.ask("GetNamedPoseBounds", "get_named_pose_bounds", name="moon").result
    assert lost.error_message == "There is no named pose 'moon'; there is dock, gate"
    site = '<site name="door" pos="1 0 0"/>'
    caller.do("LoadWorld", "load_world", resource_string=BALL.replace("<body", f"{site}<body"))
    (door,) = caller.do("GetNamedPoses", "get_named_poses").poses
    assert (door.name, door.pose.position.x) == ("door", 1.0)
    frame = '<frame name="bay"><pose>1 0 0 0 0 0</pose></frame>'
    frame += '<frame name="end" attached_to="bay"><pose>2 0 0 0 0 0</pose></frame>'
    sdf = f'<sdf version="1.8"><world name="w">{frame}</world></sdf>'
    caller.do("LoadWorld", "load_world", resource_string=sdf)
    places = caller.do("GetNamedPoses", "get_named_poses").poses
    assert [(each.name, each.pose.position.x) for each in places] == [("bay", 1.0), ("end", 3.0)]

    model = tmp_path / "crate"
    model.mkdir()
    (model / "model.config").write_text("<model><sdf version='1.6'>crate.sdf</sdf></model>")
    (model / "crate.sdf").write_text(
        '<sdf version="1.6"><model name="c"><link name="l"/></model></sdf>'
    )
    (tmp_path / "can.urdf").write_text(CAN)
    answer = caller.do("GetSpawnables", "get_spawnables", sources=[str(tmp_path), "/nowhere"])
    assert answer.result.error_message == "Nothing to spawn in /nowhere"
    uris = [each.uri for each in answer.spawnables]
    assert {(tmp_path / "can.urdf").as_uri(), (model / "crate.sdf").as_uri()} <= set(uris)
    # The simulator's own: the installed ones, not those of the checkout that this runs in.
    assert any(uri.endswith("/worlds/table.urdf") for uri in uris)

    kitchen = (
        "things: {shelf: {shape: box, size: [1, 1, 1]}, jar: {shape: sphere, radius: 0.1, mass: 1}}"
    )
    spawned = caller.spawn(kitchen, 3.0, name="kitchen")
    assert spawned.entity_name == "kitchen"
    assert spawned.result.error_message == (
        "there is no entity 'kitchen' but kitchen/shelf and kitchen/jar, "
        "which are deleted together by that name"
    )
    assert caller.spawn(CAN, 1.0, name="kitchen").result.result != Result.RESULT_OK
    assert caller.names(filter="kitchen") == ["kitchen/shelf", "kitchen/jar"]
    caller.do("DeleteEntity", "delete_entity", entity="kitchen")
    assert not caller.names(filter="kitchen")
    caller.do("LoadWorld", "load_world", uri=str(TABLE))


def test_another_world_is_loaded_and_unloaded(caller: Caller) -> None:
    loaded = caller.do("LoadWorld", "load_world", resource_string=BALL)
    assert loaded.world.name == "yard"
    assert (caller.names(), caller.state()) == (["teleop", "ball"], State.STATE_STOPPED)
    broken = caller.ask("LoadWorld", "load_world", uri="/no/such/world.urdf").result
    assert (broken.result, caller.names()) == (Result.RESULT_NOT_FOUND, ["teleop", "ball"])
    caller.do("UnloadWorld", "unload_world")
    assert caller.names() == ["teleop"]
    current = caller.ask("GetCurrentWorld", "get_current_world").result
    assert current.error_message == "There is nothing around the robot"
    known = caller.do("GetAvailableWorlds", "get_available_worlds").worlds
    table = next(world for world in known if world.name == "table")
    caller.do("LoadWorld", "load_world", uri=table.world_resource.uri)
    assert caller.names() == ["teleop", "table", "cube"]


def test_gravity_is_a_parameter_and_another_world_has_its_own(caller: Caller) -> None:
    """Of the world: falls by what is set, in words where that makes no sense."""
    set_ = get_service("rcl_interfaces/srv/SetParameters")
    client = caller.create_client(set_, "/mujoco_sim/set_parameters")
    assert client.wait_for_service(LONGEST_WAIT_S)

    def set_gravity(*gravity: float) -> Any:
        value = Parameter("gravity", value=list(gravity)).to_parameter_msg()
        request = set_.Request(parameters=[value])
        response: Any = client.call(request, timeout_sec=LONGEST_WAIT_S)
        return response.results[0]

    def gravity() -> list[float]:
        get = get_service("rcl_interfaces/srv/GetParameters")
        asking = caller.create_client(get, "/mujoco_sim/get_parameters")
        response: Any = asking.call(get.Request(names=["gravity"]), timeout_sec=LONGEST_WAIT_S)
        return list(response.values[0].double_array_value)

    assert gravity() == [0.0, 0.0, -9.81]
    caller.spawn(CAN, 2.0)
    assert set_gravity(0.0, 0.0, -1.62).successful
    caller.spawn(BOX, 3.0)
    caller.step(100)
    fallen = 1.0 - 1.62 * 0.1 * 0.101 / 2.0
    assert (caller.height("can"), caller.height("box")) == pytest.approx((fallen, fallen))
    for wrong, why in (
        ((0.0, 0.0), "expected x, y and z"),
        ((0.0, 0.0, float("nan")), "is not finite"),
        ((0.0, 0.0, -1e300), "is beyond 1e+09"),
    ):
        refused = set_gravity(*wrong)
        assert (refused.successful, why in refused.reason) == (False, True)
    caller.do("LoadWorld", "load_world", resource_string="things: {}\ngravity: [0, 0, -3.7]")
    assert gravity() == [0.0, 0.0, -3.7]
    caller.do("LoadWorld", "load_world", uri=str(TABLE))
    assert gravity() == [0.0, 0.0, -9.81]


def test_all_contacts_and_the_pace_are_on_topics_for_those_who_listen(caller: Caller) -> None:
    touching: list[set[str]] = []
    paces: queue.SimpleQueue[float] = queue.SimpleQueue()

    def see(message: Any) -> None:
        pairs = [(one.collision1.name, one.collision2.name) for one in message.contacts]
        touching.extend({*pair} for pair in pairs)

    contacts = get_message("ros_gz_interfaces/msg/Contacts")
    caller.create_subscription(contacts, "/mujoco_sim/contacts", see, 10, immediate=True)
    caller.create_subscription(
        get_message("gazebo_msgs/msg/PerformanceMetrics"),
        "/performance_metrics",
        lambda message: paces.put(message.real_time_factor),
        10,
        immediate=True,
    )
    caller.step(3000)  # the cube sleeps
    while {"cube_collision", "table_collision"} not in touching:  # until it sees who listens
        caller.step(100)
    assert paces.get(timeout=LONGEST_WAIT_S) == 0.0, "time stands still"


def test_a_state_is_saved_under_a_name_and_gone_back_to(caller: Caller, tmp_path: Path) -> None:
    caller.spawn(CAN, 2.0)
    caller.step(300)
    height = caller.height("can")
    kept = str(tmp_path / "state.json")
    for name in ("falling", kept):
        assert caller.call("ResetWorld", "save_world", keyframe=name).success
    caller.step(300)
    for name in ("falling", kept):
        seen = len(caller.states)
        answer = caller.call("ResetWorld", "reset_world", keyframe=name)
        assert answer.success, answer.message
        assert caller.height("can") == height
        caller.step(1)
        caller.wait_for_states(seen + 1)
        assert stamp_ns(caller.states[seen]) < 300_000_000, "controllers see that time began anew"
    caller.do("DeleteEntity", "delete_entity", entity="can")
    for name, why in (
        ("falling", "another model: it has the body 'can'"),
        ("flying", "There is no keyframe 'flying'; there is falling"),
        ("./state.json", "give an absolute one"),
        (str(tmp_path / "none.json"), "No such file"),
    ):
        refused = caller.call("ResetWorld", "reset_world", keyframe=name)
        assert (refused.success, why in refused.message) == (False, True), refused.message


def test_the_command_line_has_words_for_them(
    caller: Caller, shared_ros: RosGraph, tmp_path: Path
) -> None:
    """Each of which says in a line, or as JSON, what came of it."""
    (tmp_path / "can.urdf").write_text(CAN)

    def sim(*words: str) -> str:
        done = shared_ros.run(["sim", *words], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert sim("spawn", "can.urdf", "--at=2,0,1") == "Spawned can"
    assert json.loads(sim("list", "--json")) == ["teleop", "table", "cube", "can"]
    (tmp_path / "kitchen.yaml").write_text(
        "things: {shelf: {shape: box, size: [1, 1, 1], at: [9, 0, 1]}, "
        "jar: {shape: sphere, radius: 0.1, mass: 1, at: [9, 0, 2]}}"
    )
    assert sim("spawn", "kitchen.yaml") == "Spawned kitchen/shelf, kitchen/jar"
    assert sim("delete", "kitchen") == "Deleted kitchen"
    assert sim("step", "200") == "Advanced by 200 steps"
    height = caller.height("can")
    assert sim("save", "state.json") == f"Saved into {tmp_path / 'state.json'}"
    assert sim("play") == "The simulation is running"
    assert json.loads(sim("pause", "--json")) == {"message": "The simulation is paused"}
    sim("load", "state.json")
    assert caller.height("can") == height
    assert sim("delete", "can") == "Deleted can"
    refused = shared_ros.run(["sim", "load", "state.json"], cwd=tmp_path)
    assert (refused.returncode, "it has the body 'can'" in refused.stderr) == (1, True)
    assert sim("reset") == "The simulation was reset"
