"""Fixtures for all tests: isolated ROS environments with real processes.

Chooses how to draw before any test module imports mujoco. A machine that cannot draw fails the
tests that need it, with the packages to install.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.sim.gl_backend import choose_backend
from tests.processes import RosEnvironment

with contextlib.suppress(TeleopctlError):
    choose_backend()


@pytest.fixture
def ros_without_router(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RosEnvironment]:
    """An isolated environment in which no router runs yet; this process is in it as well."""
    yield from _environment(tmp_path, monkeypatch)


@pytest.fixture
def ros(ros_without_router: RosEnvironment) -> RosEnvironment:
    """An isolated environment with its router running; this process is in it as well."""
    ros_without_router.start_router()
    return ros_without_router


@pytest.fixture(scope="module")
def shared_ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosEnvironment]:
    """One environment with a router for all tests of a module that only look."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        for environment in _environment(tmp_path_factory.mktemp("ros"), monkeypatch):
            environment.start_router()
            yield environment


def _environment(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RosEnvironment]:
    environment = RosEnvironment(folder)
    for name in ("ZENOH_SESSION_CONFIG_URI", "ZENOH_ROUTER_CONFIG_URI", "ZENOH_CONFIG_OVERRIDE"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.variables.items():
        monkeypatch.setenv(name, value)
    yield environment
    environment.close()
