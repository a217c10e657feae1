"""For all tests: names for the plug-in's fixtures, and a user who is thrown away.

Chooses how to draw before any test module imports mujoco. A machine that cannot draw fails the
tests that need it, with the packages to install.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import site
import subprocess
import sys
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from teleopctl.base import background
from teleopctl.errors import TeleopctlError
from teleopctl.launch.execution.running import running
from teleopctl.sim.gl_backend import choose_backend
from teleopctl.testing import RosGraph, free_port, pytest_plugin
from tests.reaper import watch_over

_BENCHMARKS = Path(__file__).with_name("benchmarks")
_FOLDER = pytest.StashKey[Path]()
_REAPER = pytest.StashKey[subprocess.Popen[bytes]]()

# The only place that sets how many examples a property test tries. By default few, and the same
# each time, so that a change is judged by itself; `--hypothesis-profile=nightly` tries many others.
# Neither has a deadline: how long an example takes depends on the machine's other work.
_SETTINGS = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("teleopctl", _SETTINGS, max_examples=12, derandomize=True)
settings.register_profile("nightly", _SETTINGS, max_examples=400)
settings.load_profile("teleopctl")

# The tests draw in this process with a backend that is chosen before mujoco is imported; processes
# that a test starts choose one themselves, as a user's do.
if not os.environ.get("MUJOCO_GL"):
    with contextlib.suppress(TeleopctlError):
        choose_backend()
        import mujoco  # noqa: F401

    os.environ.pop("MUJOCO_GL", None)


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Share out the whole folder; what is named in it starts no workers for itself.

    Half of its time a worker waits for what a test has started: the cores are enough for two more.
    """
    named = [config.invocation_params.dir / argument for argument in config.args]
    is_whole = any(Path(__file__).parent.is_relative_to(path) for path in named)
    return (os.cpu_count() or 1) + 2 if is_whole else 0


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Run benchmarks only where they are named: ``pytest tests/benchmarks``."""
    if collection_path != _BENCHMARKS:
        return None
    named = [config.invocation_params.dir / argument.split("::")[0] for argument in config.args]
    return None if any(path.is_relative_to(_BENCHMARKS) for path in named) else True


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no rings of objects meanwhile, nor later in what is read: all of it stays.

    That would be a third of the work of each worker before its first test.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Start with the tests that have a longer timeout, so that no worker is left alone with one."""
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: item.get_closest_marker("timeout") is None)


def pytest_configure(config: pytest.Config) -> None:
    """Let no test reach the user's files, processes and nodes, with a fixture or without.

    Each variable also stands behind another one, so that a test may delete any of them.
    """
    # A shell has what it starts with & ignore Ctrl-C, and so would all that tests start.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # The tests start about two thousand programs; without bytecode each compiles all it imports.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    # A checkout that is only on the path has no entry points.
    if not config.pluginmanager.hasplugin("teleopctl"):
        config.pluginmanager.register(pytest_plugin, "teleopctl")
    # A worker inherits TMPDIR, which is to be changed below.
    place = os.environ.setdefault("TESTS_TMPDIR", tempfile.gettempdir())
    folder = Path(tempfile.mkdtemp(prefix="teleopctl-tests-", dir=place))
    config.stash[_FOLDER] = folder
    config.stash[_REAPER] = watch_over(folder)
    # Python finds what is installed for the user alone below the home folder.
    os.environ.setdefault("PYTHONUSERBASE", site.getuserbase())
    for name in ("HOME", "USERPROFILE"):
        os.environ[name] = str(folder)
    for name in ("CACHE_HOME", "CONFIG_HOME", "DATA_HOME", "STATE_HOME", "RUNTIME_DIR"):
        # Others may not read them, else XDG_RUNTIME_DIR does not count.
        (folder / name.lower()).mkdir(mode=0o700)
        os.environ[f"XDG_{name}"] = str(folder / name.lower())
    os.environ["TELEOPCTL_RUNTIME_DIR"] = str(folder / "runtime")
    os.environ["ROS_LOG_DIR"] = str(folder / "log")
    os.environ["TELEOPCTL_ROUTER"] = f"tcp/127.0.0.1:{free_port()}"
    os.environ["ROS_DOMAIN_ID"] = "231"
    os.environ["TELEOPCTL_VIEWER"] = "false"
    # What a program that is killed had in use goes with the folder; a test's own stays for a look.
    (folder / "tmp").mkdir()
    os.environ["TMPDIR"] = str(folder / "tmp")
    # What a ROS that was sourced has installed is none of a test's business.
    for name in ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH"):
        os.environ.pop(name, None)


def pytest_unconfigure(config: pytest.Config) -> None:
    """End what a test without a graph of its own left behind."""
    folder = config.stash[_FOLDER]
    for records in ("runtime", "runtime_dir/teleopctl"):
        for entry in running(folder / records):
            background.stop(entry.record)
    config.stash[_REAPER].communicate()


@pytest.fixture(autouse=True)
def _no_variables_of_other_tests() -> Iterator[None]:
    """Let a test hand no environment variables on: a launch sets those of a sourced ROS 2."""
    before = dict(os.environ)
    yield
    if os.environ != before:
        os.environ.clear()
        os.environ.update(before)


@pytest.fixture(autouse=True)
def _no_packages_of_other_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the packages of files that a test gives by path be found in that test alone."""
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")


@pytest.fixture
def ros_without_router(ros_graph_without_router: RosGraph) -> RosGraph:
    """The plug-in's graph under the tests' short name, without a router."""
    return ros_graph_without_router


@pytest.fixture
def ros_with_own_router(ros_graph_without_router: RosGraph) -> RosGraph:
    """A graph with a router of the test's own, which `teleopctl daemon` and `ps` list."""
    ros_graph_without_router.start_router()
    return ros_graph_without_router


@pytest.fixture
def ros(ros_graph: RosGraph) -> RosGraph:
    """The plug-in's graph under the tests' short name."""
    return ros_graph


@pytest.fixture(scope="module")
def shared_ros(shared_ros_graph: RosGraph) -> RosGraph:
    """The plug-in's graph of a module under the tests' short name."""
    return shared_ros_graph
