"""Files of a new controller in a Python package: its code, its parameters, and a test."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.package import File, Folder, NewPackage, Step, join_path

_CODE: Final = '''\
"""The controller {type}."""

from teleopctl.control import (
    POSITION,
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)


class {class_name}(ControllerInterface):
    """Moves a joint to a goal, no faster than a speed.

    Changed code goes on from where the joint is: teleopctl control reload --watch {name}
    """

    def on_configure(self):
        self.joint = self.auto_declare('joint', '')
        self.goal = self.auto_declare('goal', 0.0)  # rad or m
        self.speed = self.auto_declare('speed', 0.2)  # rad/s or m/s

    def command_interface_configuration(self):
        names = [f'{{self.joint}}/{{POSITION}}']
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    state_interface_configuration = command_interface_configuration

    def on_activate(self):
        self.reference = self.state_interfaces[0].value

    def update(self, time_ns, period):
        step = self.speed * period
        self.reference += max(-step, min(step, self.goal - self.reference))
        self.command_interfaces[0].value = self.reference
'''

_TEST: Final = '''\
"""Tests of the controller {type}, in memory."""

from pytest import approx
from teleopctl.testing import ControlStack, serial_robot


def test_it_moves_at_its_speed_and_stays_at_the_goal():
    stack = ControlStack(serial_robot(joints=1, initial=(0.3,)), update_rate=100)
    parameters = {{'joint': 'joint1', 'goal': 0.5, 'speed': 0.2}}
    stack.load_controller('{name}', '{package}.{name}:{class_name}', parameters)
    stack.activate('{name}')
    stack.step(50)
    assert stack.command('joint1/position') == approx(0.4)
    stack.step(100)
    assert stack.command('joint1/position') == approx(0.5)
'''

_PARAMETERS: Final = """\
controller_manager:
  ros__parameters:
    update_rate: 100
    joint_state_broadcaster: {{type: joint_state_broadcaster/JointStateBroadcaster}}
    {name}: {{type: {type}}}
{name}:
  ros__parameters: {{joint: joint_1, goal: 0.5}}
"""

# pytest puts the folder of this file on the import path.
_CONFTEST: Final = '"""Makes the package importable for its tests."""\n'


def controller_names(given: str) -> tuple[str, str]:
    """Return a controller's name and its class: ``gentle_arm`` and ``GentleArm`` for either."""
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", given).lower()
    return name, "".join(part[:1].upper() + part[1:] for part in given.split("_"))


def controller_entry_point(package: NewPackage) -> str:
    """Return the entry point ``package/Class = package.module:Class`` of the new controller."""
    name, class_name = controller_names(package.controller or "")
    return f"{package.name}/{class_name} = {package.name}.{name}:{class_name}"


def controller_files(package: NewPackage, folder: str) -> Iterator[Step]:
    """Yield the steps that create the controller's files."""
    name, class_name = controller_names(package.controller or "")
    words = {
        "name": name,
        "class_name": class_name,
        "package": package.name,
        "type": f"{package.name}/{class_name}",
    }
    yield File(join_path(folder, package.name, f"{name}.py"), _CODE.format(**words))
    yield Folder(join_path(folder, "config"))
    yield File(join_path(folder, "config", f"{name}.yaml"), _PARAMETERS.format(**words))
    yield File(join_path(folder, "conftest.py"), _CONFTEST)
    yield File(join_path(folder, "test", f"test_{name}.py"), _TEST.format(**words))
