"""Makes ``rclpy`` and ROS 2's other packages importable for the tests of this folder."""

import teleopctl

teleopctl.activate()
