"""Fixtures: description of the teleop arm, expanded once for all tests of this folder."""

import pytest

from teleopctl.packages import package_share
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro


@pytest.fixture(scope="session")
def teleop_urdf() -> str:
    return expand_xacro(package_share("teleop_description") / "urdf" / "teleop.urdf.xacro")


@pytest.fixture(scope="session")
def teleop(teleop_urdf: str) -> RobotDescription:
    return RobotDescription.from_urdf(teleop_urdf)
