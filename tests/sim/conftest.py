"""Chooses how to draw before any test module imports mujoco.

A machine that cannot draw fails the tests that need it, with the packages to install.
"""

import contextlib

from teleopctl.errors import TeleopctlError
from teleopctl.sim.gl_backend import choose_backend

with contextlib.suppress(TeleopctlError):
    choose_backend()
