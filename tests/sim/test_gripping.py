"""What the arm's gripper holds."""

import numpy as np
import pytest

from teleopctl.mujoco_model.model import build_model
from teleopctl.packages import package_share
from teleopctl.robot import read_world
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.sim.simulation import Simulation
from tests.samples import sample

JOINTS = ["joint_1", "joint_2", "joint_3", "joint_4"]
POSE = [0.0, 0.3, -0.3]
OPEN, CLOSED = -0.6, 0.0

# Between the tips of the fingers, in the frame of claw_support.
GRASP = np.array([-0.13, 0.545, -0.1])


def cube(size: float, mass: float) -> str:
    inertia = mass * size**2 / 6.0
    shape = f'<geometry><box size="{size} {size} {size}"/></geometry>'
    return f"""<link name="cube">
      <inertial><mass value="{mass}"/><inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}"
        ixy="0" ixz="0" iyz="0"/></inertial>
      <visual>{shape}</visual><collision>{shape}</collision></link>
    <joint name="cube_joint" type="floating"><parent link="world"/><child link="cube"/>
      <origin xyz="2 2 0.5"/></joint>"""


class Grip:
    """The arm with its fingers around a cube, which is held in place until they have closed."""

    def __init__(self, size: float, mass: float) -> None:
        file = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
        arm = expand_xacro(str(file), {})
        urdf = arm.replace("</robot>", cube(size, mass) + "</robot>")
        model = build_model(RobotDescription.from_urdf(urdf))
        self.simulation = Simulation(model, control_period_ns=10_000_000)
        self.move(OPEN, 1.0)
        claw = self.simulation.link_pose("claw_support")
        place = np.array([*(claw.position + claw.rotation @ GRASP), *claw.quaternion])
        for _ in range(100):
            self.simulation.apply(JOINTS, position=[*POSE, CLOSED])
            for _ in range(self.simulation.steps_to_tick):
                self.simulation.free_bodies.put(0, place)
                self.simulation.step(1)
        self.start = self.in_claw()

    def move(self, finger: float, seconds: float) -> None:
        for _ in range(round(100 * seconds)):
            self.simulation.apply(JOINTS, position=[*POSE, finger])
            self.simulation.step(self.simulation.steps_to_tick)

    def in_claw(self) -> np.ndarray:
        claw, held = (self.simulation.link_pose(link) for link in ("claw_support", "cube"))
        return np.array(claw.rotation.T @ (held.position - claw.position))


@pytest.mark.parametrize(
    ("size", "mass", "seconds"),
    sample(
        [(0.04, 0.05, 10), (0.04, 0.5, 30), (0.06, 0.5, 10), (0.1, 0.05, 10), (0.1, 0.5, 30)], 3
    ),
)
def test_a_cube_is_held_and_creeps_less_than_a_tenth_of_a_millimetre_a_second(
    size: float, mass: float, seconds: int
) -> None:
    grip = Grip(size, mass)
    for _ in range(seconds // 10):
        before = grip.in_claw()
        grip.move(CLOSED, 10.0)
        assert np.linalg.norm(grip.in_claw() - before) < 1e-3
    grip.move(OPEN, 1.0)
    assert np.linalg.norm(grip.in_claw() - grip.start) > 0.1, "and let go"


class Table:
    """The arm and the table of ``sim.yaml``, whose cube nothing but the fingers holds."""

    def __init__(self) -> None:
        share = package_share("teleop_description"), package_share("teleopctl")
        arm = expand_xacro(share[0] / "urdf" / "teleop.urdf.xacro")
        world = read_world(share[1] / "worlds" / "table.urdf")
        model = build_model(RobotDescription.from_urdf(arm), world=world)
        assert (model.warnings, model.excluded) == ((), ())
        self.simulation = Simulation(model, control_period_ns=100_000_000)
        self.sent = np.zeros(4)

    def move(self, *target: float) -> None:
        """Move there within 2 s, at the tutorial's 10 Hz."""
        for positions in np.linspace(self.sent, target, 21)[1:]:
            self.simulation.apply(JOINTS, position=positions.tolist())
            self.simulation.step(self.simulation.steps_to_tick)
        self.sent = np.array(target)

    @property
    def cube(self) -> np.ndarray:
        return self.simulation.free_bodies.pose(0)[:3]


@pytest.mark.parametrize("down", [-0.765, -0.77, -0.78])
def test_the_cube_on_the_table_is_lifted_carried_and_dropped(down: float) -> None:
    table = Table()
    start = table.cube
    table.move(0.0, 0.0, 0.0, OPEN)
    table.move(0.0, down, 0.0, OPEN)
    assert table.cube == pytest.approx(start, abs=2e-3), "the open fingers do not touch it"
    table.move(0.0, down, 0.0, CLOSED)
    table.move(0.0, -0.4, 0.0, CLOSED)
    assert table.cube[2] > 0.6
    table.move(0.8, -0.4, 0.0, CLOSED)
    assert table.cube == pytest.approx([-1.3, 1.06, 0.7], abs=0.1)
    table.move(0.8, -0.4, 0.0, OPEN)
    assert table.cube[2] < 0.1

    table.simulation.reset_state()
    assert table.cube == pytest.approx(start, abs=0.0)
