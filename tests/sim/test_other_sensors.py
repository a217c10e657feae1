"""Contacts, magnetic field, place on the earth and height: judged by mechanics and geodesy."""

import math
from pathlib import Path

import numpy as np
import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.sim.building import simulate
from teleopctl.sim.sensors.geodesy import GeoPoint
from tests.sim.robots import box, control, joint, link
from tests.sim.test_sensors import Measured, gazebo

BOX = """<inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0"
  iyz="0"/></inertial>""" + box("collision", "0.2 0.2 0.2")
BUMPER = '<plugin name="p" filename="libgazebo_ros_bumper.so"><ros>{}</ros></plugin>'


def read(measured: Measured, index: int = 0):
    sensor = measured.sensors[index]
    message = get_message(sensor.message_type)()
    sensor.read(*measured.simulation.observe(), message)
    return message


def resting(content: str) -> Measured:
    """A box of 2 kg on the ground."""
    free = joint("free", "world", "crate", kind="floating", xyz="0 0 0.1", limit="")
    crate = link("crate", BOX)
    measured = Measured(link("world", ""), crate, free, gazebo("crate", content, "contact"))
    measured.simulation.step(1000)
    return measured


def turntable(*sensors: str, commands: str = "velocity") -> Measured:
    """A mast of 0.5 m that turns about z, and lifts its sensors a metre to the side of it."""
    return Measured(
        link("base", ""),
        link("mast"),
        joint("turn", "base", "mast", axis="0 0 1", kind="continuous",
              limit='effort="200" velocity="30"'),
        control(turn=commands),
        *sensors,
    )  # fmt: skip


@pytest.mark.parametrize("classic", [True, False])
def test_a_contact_carries_the_weight_of_what_rests_on_it(classic: bool) -> None:
    plugin = BUMPER.format("<remapping>bumper_states:=bump</remapping>") if classic else ""
    measured = resting(f"<contact><collision>crate_collision</collision></contact>{plugin}")
    message = read(measured)
    sensor = measured.sensors[0]

    assert sensor.frame_id == "world"
    if classic:
        assert (sensor.topic, sensor.message_type) == ("bump", "gazebo_msgs/msg/ContactsState")
        (state,) = message.states
        names = state.collision1_name, state.collision2_name
        forces = [wrench.force.z for wrench in state.wrenches]
        normals, depths = state.contact_normals, state.depths
        assert state.total_wrench.force.z == pytest.approx(sum(forces))
    else:
        (state,) = message.contacts
        names = state.collision1.name, state.collision2.name
        forces = [wrench.body_1_wrench.force.z for wrench in state.wrenches]
        normals, depths = state.normals, state.depths
    assert names[0] == "crate_collision" and "ground" in names[1]
    assert sum(forces) == pytest.approx(2 * 9.81, rel=1e-3)
    assert all(normal.z == pytest.approx(1.0) for normal in normals)
    assert all(0.0 <= depth < 1e-3 for depth in depths)


def test_what_touches_nothing_has_no_contacts() -> None:
    measured = resting("<contact><topic>bump</topic></contact>")
    measured.simulation.free_bodies.put(0, np.array([0, 0, 3.0, 1, 0, 0, 0]))
    measured.simulation.refresh()

    assert measured.sensors[0].topic == "bump"
    assert read(measured).contacts == []


def test_a_magnetometer_turns_against_the_field() -> None:
    turned = f"<pose>0 0 0 0 0 {math.pi / 2}</pose>"
    measured = turntable(
        gazebo("mast", "", "magnetometer", "a"), gazebo("mast", turned, "magnetometer", "b")
    )
    north, west = (read(measured, index).magnetic_field for index in range(2))

    assert (north.x, north.y, north.z) == pytest.approx((5.5645e-6, 22.8758e-6, -42.3884e-6))
    # Turned to the left by a quarter, its x axis points north and its y axis west.
    assert (west.x, west.y, west.z) == pytest.approx((22.8758e-6, -5.5645e-6, -42.3884e-6))


def test_heights_are_those_of_the_sensor() -> None:
    pose = "<pose>0 0 0.3 0 0 0</pose>"
    measured = turntable(
        gazebo("mast", pose, "altimeter", "a"), gazebo("mast", pose, "air_pressure", "b")
    )

    assert read(measured).vertical_position == pytest.approx(0.8)
    # Near sea level a metre of air weighs 12.0 Pa.
    assert read(measured, 1).fluid_pressure == pytest.approx(101325 - 0.8 * 12.01, abs=0.05)


def test_a_gps_is_on_the_earth_where_the_world_is_and_its_plugin_tells_the_velocity() -> None:
    plugin = '<plugin name="p" filename="libgazebo_ros_gps_sensor.so"/>'
    measured = turntable(gazebo("mast", f"<pose>1 0 0 0 0 0</pose>{plugin}", "gps"))
    for sensor in measured.sensors:
        sensor.origin = GeoPoint(47.0, 8.0, 400.0)
    simulation = measured.simulation
    for _ in range(100):
        simulation.apply(["turn"], velocity=[2.0])
        simulation.step(simulation.steps_per_period)
    simulation.read()
    angle = float(simulation.positions[0])
    fix, velocity = read(measured), read(measured, 1)

    assert [sensor.topic for sensor in measured.sensors] == ["p/out", "p/vel"]
    # A degree of latitude is 111.17 km there, one of longitude 76.05 km.
    assert (fix.longitude - 8.0) * 76_050 == pytest.approx(math.cos(angle), abs=2e-3)
    assert (fix.latitude - 47.0) * 111_170 == pytest.approx(math.sin(angle), abs=2e-3)
    assert fix.altitude == pytest.approx(400.5, abs=1e-4)
    east, north = velocity.vector.x, velocity.vector.y
    speed = 2.0 * np.array([-math.sin(angle), math.cos(angle)])
    assert (east, north) == pytest.approx(tuple(speed), abs=0.02)


def test_places_on_the_earth_are_moved_by_metres() -> None:
    home = GeoPoint(47.0, 8.0, 400.0)
    assert home.offset(0, 0, 0) == pytest.approx(home, abs=1e-9)
    # Along the equator 1 degree is 111319.49 m; a quarter of the meridian is 10001965.7 m long.
    assert GeoPoint().offset(0, 0, 10.0) == pytest.approx((0, 0, 10.0), abs=1e-6)
    assert GeoPoint(0, 0, 0).offset(111.31949, 0, 0).longitude == pytest.approx(1e-3, abs=1e-9)
    assert GeoPoint(90, 0, 0).offset(0, 0, 5.0).altitude_m == pytest.approx(5.0, abs=1e-6)


def test_gazebo_classics_plugin_of_forces_is_a_sensor() -> None:
    plugin = """<gazebo><plugin name="ft" filename="libgazebo_ros_ft_sensor.so"><ros>
      <namespace>/arm</namespace><remapping>wrench:=force</remapping></ros>
      <joint_name>hang</joint_name><frame_name>wrist</frame_name><update_rate>50</update_rate>
      </plugin></gazebo>"""
    measured = Measured(
        link("base", ""), link("load"), joint("hang", "base", "load", kind="fixed"), plugin
    )
    (sensor,) = measured.sensors

    assert (sensor.topic, sensor.frame_id) == ("/arm/force", "wrist")
    assert sensor.description.update_rate == 50
    assert read(measured).wrench.force.z == pytest.approx(-0.5 * 9.81, rel=1e-3)
    assert measured.warnings == []


def test_an_sdf_world_says_where_on_the_earth_it_is(tmp_path: Path) -> None:
    file = tmp_path / "field.sdf"
    file.write_text(
        "<sdf version='1.9'><world name='field'><spherical_coordinates><latitude_deg>47.4"
        "</latitude_deg><elevation>408</elevation></spherical_coordinates></world></sdf>"
    )
    tags = link("base", "") + gazebo("base", "", "navsat")
    for said, origin in (((), GeoPoint(47.4, 0.0, 408.0)), ((1.0, 2.0, 3.0), GeoPoint(1, 2, 3))):
        robot = simulate(
            f"<robot name='r'>{tags}</robot>",
            world=str(file),
            fixed_base=True,
            control_period_ns=10_000_000,
            gps_origin=said,
        )
        assert robot.sensors[0].origin == origin
