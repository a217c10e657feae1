"""Write a controller and run it without ROS: python controller.py"""

import math

import teleopctl
from teleopctl.testing import serial_robot


class Wave(teleopctl.ControllerInterface):
    """Swings a joint about zero, once every two seconds."""

    def command_interface_configuration(self) -> teleopctl.InterfaceConfiguration:
        kind = teleopctl.InterfaceConfigurationType.INDIVIDUAL
        return teleopctl.InterfaceConfiguration(kind, ["joint1/position"])

    def on_activate(self) -> None:
        self.amplitude = self.auto_declare("amplitude", 0.1)
        self.phase = 0.0

    def update(self, time_ns: int, period: float) -> None:
        self.phase += math.pi * period
        self.command_interfaces[0].value = self.amplitude * math.sin(self.phase)


stack = teleopctl.ControlStack(serial_robot(joints=1), update_rate=100)
stack.load_controller("wave", "__main__:Wave", {"amplitude": 0.5})
stack.activate("wave")
for _ in range(4):
    stack.step(25)
    print(f"joint1 is at {stack.state('joint1/position'):+.3f} rad")
