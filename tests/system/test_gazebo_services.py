"""Gazebo classic's services, called as programs that were written for Gazebo call them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from teleopctl.interfaces import get_message, get_service
from teleopctl.testing import LONGEST_WAIT_S, RosGraph
from teleopctl.wire import EntityKind
from tests.system.sim_partner import Partner

ROBOT = """<robot name="post"><link name="world"/><link name="head"/>
<joint name="neck" type="fixed"><parent link="world"/><child link="head"/>
  <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/></joint></robot>"""
CRATE = """<sdf version="1.6"><model name="crate"><pose>0 0 0.5 0 0 0</pose><link name="wood">
  <inertial><mass>2</mass></inertial>
  <collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
</link></model></sdf>"""
WEIGHT_N = 2 * 9.81


class Caller(Partner):
    """Calls services by the types of Gazebo."""

    def ask(self, service: str, name: str, /, **request: Any) -> Any:
        kind = get_service(service if "/" in service else f"gazebo_msgs/srv/{service}")
        return self.call_as(kind, name, kind.Request(**request))

    def spawn(self, name: str, x: float, **request: Any) -> Any:
        pose = get_message("geometry_msgs/msg/Pose")()
        pose.position.x = x
        return self.ask(
            "SpawnEntity", "/spawn_entity", name=name, xml=CRATE, initial_pose=pose, **request
        )

    def state(self, name: str, frame: str = "") -> Any:
        answer = self.ask("GetEntityState", "/get_entity_state", name=name, reference_frame=frame)
        assert answer.success
        return answer.state

    def step(self, count: int) -> None:
        self.ask("simulation_interfaces/srv/StepSimulation", "/step_simulation", steps=count)

    def models(self) -> list[str]:
        return list(self.ask("GetModelList", "/get_model_list").model_names)


@pytest.fixture(scope="module")
def caller(shared_ros: RosGraph) -> Iterator[Caller]:
    partner = Caller(ROBOT)
    flags = ["-p", "paused:=true", "-p", "real_time_factor:=0"]
    sim = shared_ros.spawn_module(
        "teleopctl.nodes", ["mujoco_sim", "mujoco_sim", "--ros-args", *flags]
    )
    sim.wait_for_line("Simulation is paused")
    yield partner
    partner.close()


def test_models_come_and_go_by_gazebos_services(caller: Caller) -> None:
    standard = "simulation_interfaces/srv/SpawnEntity"
    assert caller.wait_for_match(EntityKind.SS, "/spawn_entity", standard, 1, LONGEST_WAIT_S)
    known = dict(caller.get_service_names_and_types())
    assert known["/spawn_entity"] == [standard], "nobody has asked for Gazebo's"

    spawned = caller.spawn("box", 3.0)
    assert spawned.success and "Successfully spawned entity [box]" in spawned.status_message
    # Its own pose is added, and that of the frame: x of the head is y of the world.
    assert caller.spawn("", 2.0, reference_frame="post::head").success
    assert caller.models() == ["post", "box", "crate"]
    box, crate = caller.state("box").pose.position, caller.state("crate").pose.position
    assert (box.x, box.y, box.z) == pytest.approx((3.0, 0.0, 0.5))
    assert (crate.x, crate.y, crate.z) == pytest.approx((1.0, 2.0, 0.5))
    taken = caller.spawn("box", 0.0)
    assert (taken.success, taken.status_message) == (False, "There is 'box' already")
    lost = caller.spawn("other", 0.0, reference_frame="moon")
    assert not lost.success and "'moon'" in lost.status_message

    assert caller.ask("DeleteEntity", "/delete_entity", name="crate").success
    assert not caller.ask("DeleteEntity", "/delete_entity", name="crate").success
    assert caller.models() == ["post", "box"]
    assert caller.ask("DeleteEntity", "/delete_entity", name="box").success


def test_states_are_told_and_set_as_seen_from_a_frame(caller: Caller) -> None:
    assert caller.spawn("box", 3.0).success
    state = get_message("gazebo_msgs/msg/EntityState")(name="box", reference_frame="head")
    state.pose.position.x, state.pose.position.z, state.twist.linear.x = 2.0, 5.0, 1.0
    assert caller.ask("SetEntityState", "/gazebo/set_entity_state", state=state).success

    there = caller.state("box::wood")
    assert (there.pose.position.x, there.pose.position.y) == pytest.approx((1.0, 2.0))
    assert (there.twist.linear.x, there.twist.linear.y) == pytest.approx((0.0, 1.0), abs=1e-9)
    seen = caller.state("box", "post::head")
    assert (seen.pose.position.x, seen.twist.linear.x) == pytest.approx((2.0, 1.0))
    state.name = "chair"
    assert not caller.ask("SetEntityState", "/set_entity_state", state=state).success

    caller.ask("std_srvs/srv/Empty", "/reset_world")
    assert caller.state("box").pose.position.x == pytest.approx(3.0)
    assert caller.ask("DeleteEntity", "/delete_entity", name="box").success


def test_a_wrench_acts_until_it_is_cleared(caller: Caller) -> None:
    assert caller.spawn("box", 3.0).success
    wrench = get_message("geometry_msgs/msg/Wrench")()
    wrench.force.z = WEIGHT_N
    endless = get_message("builtin_interfaces/msg/Duration")(sec=-1)
    request = {"link_name": "box::wood", "wrench": wrench, "duration": endless}
    assert caller.ask("ApplyLinkWrench", "/apply_link_wrench", **request).success
    caller.step(500)
    assert caller.state("box").pose.position.z == pytest.approx(0.5, abs=1e-3), "it floats"

    caller.ask("LinkRequest", "/clear_link_wrenches", link_name="box::wood")
    caller.step(200)
    assert caller.state("box").pose.position.z == pytest.approx(0.5 - 9.81 / 2 * 0.2**2, abs=5e-3)
    request["link_name"] = "chair::leg"
    refused = caller.ask("ApplyLinkWrench", "/apply_link_wrench", **request)
    assert not refused.success and "'chair::leg'" in refused.status_message

    caller.ask("std_srvs/srv/Empty", "/reset_simulation")
    answer = caller.ask("GetEntityState", "/get_entity_state", name="box")
    stamp = answer.header.stamp
    assert (stamp.sec, stamp.nanosec, answer.state.pose.position.z) == (0, 0, 0.5)
    paused = caller.clocks[-1] if caller.clocks else 0
    caller.ask("std_srvs/srv/Empty", "/unpause_physics")
    caller.wait(lambda: caller.clocks and caller.clocks[-1] > paused)
    caller.ask("std_srvs/srv/Empty", "/pause_physics")
    assert caller.ask("DeleteEntity", "/delete_entity", name="box").success
