"""Simulate a robot and plot a joint: python simulate.py [PICTURE]"""

import math
import sys

import matplotlib.pyplot as plt

import teleopctl

robot = teleopctl.load_robot("package://teleop_description/urdf/teleop.urdf.xacro")
simulation = teleopctl.RobotSimulation(robot, control_rate_hz=100)

times, commands, positions = [], [], []
for tick in range(300):
    commands.append(0.5 * math.sin(2 * math.pi * tick / 100))
    simulation.command({"joint_1": commands[-1]})
    simulation.step()
    times.append(simulation.time_s)
    positions.append(simulation.positions["joint_1"])

plt.plot(times, commands, label="commanded")
plt.plot(times, positions, label="simulated")
plt.xlabel("time (s)")
plt.ylabel("joint_1 (rad)")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "joint_1.png")
error = max(abs(a - b) for a, b in zip(commands, positions, strict=True))
print(f"joint_1 followed to within {error:.4f} rad")
