"""One robot in three languages: URDF, SDF and MJCF are one mass, one fall and one rest."""

from pathlib import Path

import numpy as np
import pytest

from teleopctl.robot import Pose, RobotDescription, read_model, simulated
from teleopctl.sim import simulate

URDF = """<robot name="duck">
  <link name="trunk">
    <inertial><mass value="5"/><inertia ixx="0.0542" iyy="0.0833" izz="0.1042"
      ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.4 0.3 0.2"/></geometry></collision>
  </link>
  <link name="neck">
    <inertial><origin xyz="0 0 0.15"/><mass value="1"/><inertia ixx="0.0079" iyy="0.0079"
      izz="0.0008" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.15"/>
      <geometry><cylinder radius="0.04" length="0.3"/></geometry></collision>
  </link>
  <joint name="nod" type="revolute"><parent link="trunk"/><child link="neck"/>
    <origin xyz="0.1 0 0.12"/><axis xyz="0 1 0"/><dynamics damping="0.1"/>
    <limit lower="-1" upper="1" effort="40" velocity="3"/></joint>
</robot>"""
SDF = """<sdf version="1.9"><model name="duck">
  <link name="trunk">
    <inertial><mass>5</mass>
      <inertia><ixx>0.0542</ixx><iyy>0.0833</iyy><izz>0.1042</izz></inertia></inertial>
    <collision name="c"><geometry><box><size>0.4 0.3 0.2</size></box></geometry></collision>
  </link>
  <link name="neck"><pose>0.1 0 0.12 0 0 0</pose>
    <inertial><pose>0 0 0.15 0 0 0</pose><mass>1</mass>
      <inertia><ixx>0.0079</ixx><iyy>0.0079</iyy><izz>0.0008</izz></inertia></inertial>
    <collision name="c"><pose>0 0 0.15 0 0 0</pose>
      <geometry><cylinder><radius>0.04</radius><length>0.3</length></cylinder></geometry></collision>
  </link>
  <joint name="nod" type="revolute"><parent>trunk</parent><child>neck</child>
    <axis><xyz>0 1 0</xyz><dynamics><damping>0.1</damping></dynamics><limit><lower>-1</lower>
      <upper>1</upper><effort>40</effort><velocity>3</velocity></limit></axis></joint>
</model></sdf>"""
MJCF = """<mujoco model="duck"><compiler autolimits="true" angle="radian"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody><body name="trunk" pos="0 0 0.1"><freejoint/>
    <inertial pos="0 0 0" mass="5" diaginertia="0.0542 0.0833 0.1042"/>
    <geom type="box" size="0.2 0.15 0.1"/>
    <body name="neck" pos="0.1 0 0.12">
      <joint name="nod" axis="0 1 0" range="-1 1" damping="0.1" actuatorfrcrange="-40 40"/>
      <inertial pos="0 0 0.15" mass="1" diaginertia="0.0079 0.0079 0.0008"/>
      <geom type="cylinder" size="0.04 0.15" pos="0 0 0.15"/>
    </body></body></worldbody>
  <actuator><position joint="nod" kp="1000" kv="20"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("name", "text"), [("duck.urdf", URDF), ("duck.sdf", SDF), ("duck.xml", MJCF)]
)
def test_it_weighs_falls_and_comes_to_rest_as_it_is_written(
    tmp_path: Path, name: str, text: str
) -> None:
    file = tmp_path / name
    file.write_text(text)
    said: list[str] = []
    urdf = simulated(read_model(file).text).urdf
    robot = simulate(
        urdf,
        fixed_base=False,
        control_period_ns=10_000_000,
        # It falls onto a lower edge, rolls over and slides.
        spawn_pose=Pose((0.0, 0.0, 1.0), (0.0, 0.6, 0.0)),
        warn=said.append,
    )
    simulation = robot.simulation
    links = RobotDescription.from_urdf(urdf).links
    bodies = {link: robot.model.mj_model.body(link) for link in links}
    masses = {name: float(body.mass[0]) for name, body in bodies.items()}
    simulation.step_to(250_000_000)
    fallen = 1.0 - simulation.link_pose("trunk").position[2]
    simulation.step_to(5_000_000_000)
    _, data = simulation.observe()

    assert masses == pytest.approx({"trunk": 5.0, "neck": 1.0})
    assert said == []
    assert fallen == pytest.approx(9.81 * 0.25**2 / 2.0, rel=0.02)
    assert not simulation.diverged
    assert np.isfinite(data.qpos).all()
    assert np.abs(data.qvel).max() < 0.01
    # It lies flat beside where it fell, its neck held upright.
    assert (data.body("trunk").xpos[0], data.body("trunk").xpos[2]) == pytest.approx(
        (-0.1, 0.1), abs=5e-3
    )
