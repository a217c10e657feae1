"""Fixtures of all tests: short names for the plug-in's fixtures, and a temporary home folder.

The OpenGL backend is chosen before any test module imports mujoco. On a machine without one the
tests that render fail, and name the packages to install.
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
from collections import Counter
from collections.abc import Generator, Iterator
from importlib import import_module
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from teleopctl.base import background
from teleopctl.errors import TeleopctlError
from teleopctl.launch.execution.running import running
from teleopctl.sim.gl_backend import choose_backend
from teleopctl.testing import RosGraph, free_port, pytest_plugin
from tests.reaper import watch_over
from tests.samples import is_nightly

_BENCHMARKS = Path(__file__).with_name("benchmarks")
_SYSTEM = Path(__file__).with_name("system")
_FOLDER = pytest.StashKey[Path]()
_REAPER = pytest.StashKey[subprocess.Popen[bytes]]()

# The only place that sets the number of examples of a property test. By default few examples, the
# same in each run, so that a failure is due to a change of the code; `--hypothesis-profile=nightly`
# tries many others. No deadlines: the time of an example depends on the load of the machine.
_SETTINGS = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("teleopctl", _SETTINGS, max_examples=12, derandomize=True)
settings.register_profile("nightly", _SETTINGS, max_examples=400)
settings.load_profile("teleopctl")

# Tests multiply small matrices only, and a thousand processes would start threads for large ones.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Tests in this process render with a backend that is chosen before mujoco is imported; processes
# that a test starts choose a backend themselves, as a user's processes do.
if not os.environ.get("MUJOCO_GL"):
    with contextlib.suppress(TeleopctlError):
        choose_backend()
        import mujoco  # noqa: F401

    os.environ.pop("MUJOCO_GL", None)


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return the number of workers: none, unless pytest runs the whole folder.

    A worker waits for processes of its tests half of the time: two workers more than cores fit.
    """
    named = [config.invocation_params.dir / argument for argument in config.args]
    is_whole = any(Path(__file__).parent.is_relative_to(path) for path in named)
    return (os.cpu_count() or 1) + 2 if is_whole else 0


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Ignore benchmarks unless they are named: ``pytest tests/benchmarks``."""
    if collection_path != _BENCHMARKS:
        return None
    named = [config.invocation_params.dir / argument.split("::")[0] for argument in config.args]
    return None if any(path.is_relative_to(_BENCHMARKS) for path in named) else True


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Disable garbage collection during test collection, and exempt the collected objects from it.

    Garbage collection would be a third of the work of each worker before its first test.
    """
    gc.disable()
    try:
        _import_from_different_ends(session.config)
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
        # Of what a test makes little is garbage that reference counts do not end: looked for more
        # rarely, it is a twentieth less of the work of a worker.
        gc.set_threshold(10_000, 10, 10)


def _import_from_different_ends(config: pytest.Config) -> None:
    """Import the test modules in each worker from another place on, in a circle.

    In a fresh checkout pytest has to rewrite the assertions of all of them, which takes a worker
    twice as long as all else before its first test. So each rewrites a part and reads the others'.
    """
    worker: dict[str, int] | None = getattr(config, "workerinput", None)
    if worker is None:
        return
    folder = Path(__file__).parent
    files = [file for file in sorted(folder.rglob("test_*.py")) if _BENCHMARKS not in file.parents]
    begin = int(str(worker["workerid"])[2:]) * len(files) // worker["workercount"]
    for file in files[begin:] + files[:begin]:
        # What is wrong with it, and whether it is to be skipped, is reported by its collection.
        with contextlib.suppress(Exception, pytest.skip.Exception):
            import_module(".".join(file.relative_to(folder.parent).with_suffix("").parts))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out nightly tests unless they are named; in workers, sort the others.

    Those with a longer timeout come first: a worker would run one alone at the end. Modules of
    ``tests/system``, which wait for processes, are spread among those that compute.
    """
    if not is_nightly() and not any("::" in argument for argument in config.args):
        nightly = [item for item in items if item.get_closest_marker("nightly")]
        config.hook.pytest_deselected(items=nightly)
        items[:] = [item for item in items if item not in nightly]
    if hasattr(config, "workerinput"):
        items[:] = _spread(items)
        items.sort(key=lambda item: item.get_closest_marker("timeout") is None)


def _spread(items: list[pytest.Item]) -> list[pytest.Item]:
    """Return the tests with the modules of ``tests/system`` in equal distances."""
    modules = [list(group) for _, group in groupby(items, key=lambda item: item.path)]
    places: dict[bool, float] = dict.fromkeys((False, True), 0.0)
    counts = Counter(_waits(module) for module in modules for _ in module)
    placed: list[tuple[float, list[pytest.Item]]] = []
    for module in modules:
        waits = _waits(module)
        placed.append((places[waits] / counts[waits], module))
        places[waits] += len(module)
    return [item for _, module in sorted(placed, key=lambda one: one[0]) for item in module]


def _waits(module: list[pytest.Item]) -> bool:
    return module[0].path.parent == _SYSTEM


def pytest_configure(config: pytest.Config) -> None:
    """Isolate all tests from the user's files, processes and nodes, with fixtures or without.

    Each variable is a fallback of another variable, so that a test may delete any of them.
    """
    # A process that a shell starts with & ignores SIGINT, and so would the processes of tests.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # The tests start about two thousand programs, which without bytecode files compile all imports.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    # A checkout on PYTHONPATH that is not installed has no entry points.
    if not config.pluginmanager.hasplugin("teleopctl"):
        config.pluginmanager.register(pytest_plugin, "teleopctl")
    # A worker would otherwise use the main process's TMPDIR, which is changed below.
    place = os.environ.setdefault("TESTS_TMPDIR", tempfile.gettempdir())
    folder = Path(tempfile.mkdtemp(prefix="teleopctl-tests-", dir=place))
    config.stash[_FOLDER] = folder
    config.stash[_REAPER] = watch_over(folder)
    # Python looks for packages that are installed for the user in the home folder.
    os.environ.setdefault("PYTHONUSERBASE", site.getuserbase())
    for name in ("HOME", "USERPROFILE"):
        os.environ[name] = str(folder)
    for name in ("CACHE_HOME", "CONFIG_HOME", "DATA_HOME", "STATE_HOME", "RUNTIME_DIR"):
        # XDG_RUNTIME_DIR is ignored unless the folder is private.
        (folder / name.lower()).mkdir(mode=0o700)
        os.environ[f"XDG_{name}"] = str(folder / name.lower())
    os.environ["TELEOPCTL_RUNTIME_DIR"] = str(folder / "runtime")
    os.environ["ROS_LOG_DIR"] = str(folder / "log")
    os.environ["TELEOPCTL_ROUTER"] = f"tcp/127.0.0.1:{free_port()}"
    os.environ["ROS_DOMAIN_ID"] = "231"
    os.environ["TELEOPCTL_VIEWER"] = "false"
    # Temporary files of killed programs are removed with the folder; pytest's tmp_path is kept.
    (folder / "tmp").mkdir()
    os.environ["TMPDIR"] = str(folder / "tmp")
    # Tests must not find packages of a sourced ROS 2.
    for name in ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH"):
        os.environ.pop(name, None)


def pytest_unconfigure(config: pytest.Config) -> None:
    """Stop background processes that tests without a graph of their own have left running."""
    folder = config.stash[_FOLDER]
    for records in ("runtime", "runtime_dir/teleopctl"):
        for entry in running(folder / records):
            background.stop(entry.record)
    config.stash[_REAPER].communicate()


@pytest.fixture(autouse=True)
def _no_variables_of_other_tests() -> Iterator[None]:
    """Restore the environment variables after each test; a launch sets those of a ROS 2 setup."""
    # As the operating system has them: decoding all before and after each test would take seconds.
    before = _encoded_variables().copy()
    yield
    if _encoded_variables() != before:
        os.environ.clear()
        os.environ.update({os.fsdecode(name): os.fsdecode(value) for name, value in before.items()})


def _encoded_variables() -> dict[bytes, bytes] | dict[str, str]:
    variables: dict[bytes, bytes] | dict[str, str] = vars(os.environ)["_data"]
    return variables


@pytest.fixture(autouse=True)
def _no_packages_of_other_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reset the package path for each test; files given by path add their packages to it."""
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")


@pytest.fixture
def ros_without_router(ros_graph_without_router: RosGraph) -> RosGraph:
    """Fixture: the plug-in's ``ros_graph_without_router`` under a short name."""
    return ros_graph_without_router


@pytest.fixture
def ros_with_own_router(ros_graph_without_router: RosGraph) -> RosGraph:
    """Fixture: graph with the test's own router, which `teleopctl daemon` and `ps` list."""
    ros_graph_without_router.start_router()
    return ros_graph_without_router


@pytest.fixture
def ros(ros_graph: RosGraph) -> RosGraph:
    """Fixture: the plug-in's ``ros_graph`` under a short name."""
    return ros_graph


@pytest.fixture(scope="module")
def shared_ros(shared_ros_graph: RosGraph) -> RosGraph:
    """Fixture: the plug-in's ``shared_ros_graph`` under a short name."""
    return shared_ros_graph
