"""Transmissions: the formulas of transmission_interface."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.robot import (
    DifferentialTransmission,
    FourBarLinkageTransmission,
    SimpleTransmission,
)

KINDS = (SimpleTransmission, DifferentialTransmission, FourBarLinkageTransmission)
VALUE = st.floats(-100.0, 100.0)
REDUCTION = st.floats(0.1, 200.0) | st.floats(-200.0, -0.1)


@st.composite
def transmissions(draw):
    kind = draw(st.sampled_from(KINDS))
    actuators = (1.0,) if kind is SimpleTransmission else draw(st.tuples(REDUCTION, REDUCTION))
    joints, offsets = (
        draw(st.lists(one, min_size=kind.size, max_size=kind.size)) for one in (REDUCTION, VALUE)
    )
    return kind(actuators, joints, offsets)


def values(draw, transmission):
    return draw(st.lists(VALUE, min_size=transmission.size, max_size=transmission.size))


@given(st.data(), transmissions(), st.sampled_from(SimpleTransmission.quantities))
def test_from_joints_to_actuators_and_back(data, transmission, quantity):
    joints = values(data.draw, transmission)
    actuators = transmission.joint_to_actuator(quantity, joints)
    assert transmission.actuator_to_joint(quantity, actuators) == pytest.approx(
        tuple(joints), rel=1e-6, abs=1e-6
    )


@given(st.data(), transmissions())
def test_actuators_and_joints_have_the_same_power(data, transmission):
    velocities, efforts = (values(data.draw, transmission) for _ in range(2))
    joint_velocities = transmission.actuator_to_joint("velocity", velocities)
    joint_efforts = transmission.actuator_to_joint("effort", efforts)
    power = sum(v * e for v, e in zip(velocities, efforts, strict=True))
    joint_power = sum(v * e for v, e in zip(joint_velocities, joint_efforts, strict=True))
    assert joint_power == pytest.approx(power, rel=1e-6, abs=1e-3)


@pytest.mark.parametrize(
    ("transmission", "quantity", "actuators", "joints"),
    [
        (SimpleTransmission([1], [10], [1]), "position", [50], [6]),
        (SimpleTransmission([1], [-10], [1]), "velocity", [50], [-5]),
        (SimpleTransmission([1], [10], [1]), "effort", [50], [500]),
        (SimpleTransmission([1], [10], [1]), "absolute_position", [50], [6]),
        (DifferentialTransmission([10, 10], [2, 2], [-2, 4]), "position", [30, 50], [0, 3.5]),
        (DifferentialTransmission([10, 10], [2, 2], [-2, 4]), "velocity", [30, 50], [2, -0.5]),
        (DifferentialTransmission([10, 10], [2, 2], [0, 0]), "effort", [3, 5], [160, -40]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [-2, 4]), "position", [30, 50], [-0.5, 5.75]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [0, 0]), "velocity", [30, 50], [1.5, 1.75]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [0, 0]), "effort", [3, 5], [110, 100]),
    ],
)
def test_formulas(transmission, quantity, actuators, joints):
    assert transmission.actuator_to_joint(quantity, actuators) == pytest.approx(tuple(joints))
    assert transmission.joint_to_actuator(quantity, joints) == pytest.approx(tuple(actuators))
