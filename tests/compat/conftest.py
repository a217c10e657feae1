"""The tests of this folder import what teleopctl offers to programs."""

import teleopctl

teleopctl.activate()
