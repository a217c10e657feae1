"""pytest plug-in: fixtures, and ``rclpy`` and message packages for tests to import.

pytest loads the plug-in wherever teleopctl is installed. The plug-in therefore adds one entry at
the end of the module search path, behind all installed packages, and imports no other module of
teleopctl before a fixture is used. ``teleopctl_imports = false`` in pytest's configuration disables
the entry, ``-p no:teleopctl`` the whole plug-in.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from teleopctl.nodes.bag_verification.verification import Verification
    from teleopctl.testing.graph import RosGraph
    from teleopctl.testing.launched import LaunchedSystem


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the ini setting ``teleopctl_imports``; called when pytest starts."""
    parser.addini(
        "teleopctl_imports",
        "Let tests import rclpy and message packages from teleopctl where they are not installed.",
        type="bool",
        default=True,
    )


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Make ``rclpy`` and message packages importable, unless disabled, when pytest starts."""
    if early_config.getini("teleopctl_imports"):
        from teleopctl.compat import activation
        from teleopctl.testing import launch_tests

        activation.activate()
        if launch_tests.are_imported_from(activation.SITE):
            early_config.pluginmanager.register(launch_tests)


@pytest.fixture(scope="session")
def _router_of_session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosGraph]:
    """Graph whose router the graphs of all tests use; started by the first test that needs it."""
    from teleopctl.testing.graph import RosGraph

    graph = RosGraph(tmp_path_factory.mktemp("router"))
    try:
        yield graph
    finally:
        graph.close()


@pytest.fixture
def ros_graph(ros_graph_without_router: RosGraph, _router_of_session: RosGraph) -> RosGraph:
    """Fixture: `RosGraph` of one test, with a ROS domain of its own, which the test process joins.

    The router runs until the end of the session and serves each test in turn.
    """
    ros_graph_without_router.share_router(_router_of_session)
    return ros_graph_without_router


@pytest.fixture
def ros_graph_without_router(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RosGraph]:
    """Fixture: `RosGraph` of one test, without a router until `RosGraph.start_router`."""
    yield from _graph(tmp_path, monkeypatch)


@pytest.fixture(scope="module")
def shared_ros_graph(
    tmp_path_factory: pytest.TempPathFactory, _router_of_session: RosGraph
) -> Iterator[RosGraph]:
    """Fixture: one `RosGraph` for all tests of a module that only observe the graph."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        for graph in _graph(tmp_path_factory.mktemp("ros_graph"), monkeypatch):
            graph.share_router(_router_of_session)
            yield graph


@pytest.fixture
def ros_launch(ros_graph: RosGraph) -> Callable[..., LaunchedSystem]:
    """Fixture: function that starts a launch file in ``ros_graph`` and waits until it is up."""
    return ros_graph.launch


@pytest.fixture
def ros_bag_repeats() -> Callable[..., Verification]:
    """Fixture: the function `assert_bag_repeats`, which simulates a bag again and compares."""
    from teleopctl.testing.replayed import assert_bag_repeats

    return assert_bag_repeats


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the output of processes and the logs of a failed test's graph to the test's report."""
    report = yield
    if report.failed:
        graph = getattr(item, "funcargs", {}).get("ros_graph_without_router")
        if graph is not None:
            report.sections.extend((f"ROS graph: {name}", text) for name, text in graph.reports())
    return report


def _graph(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RosGraph]:
    from teleopctl.testing.graph import RosGraph

    graph = RosGraph(folder)
    # Set through monkeypatch instead of `RosGraph.__enter__`, so that these changes and those of
    # the test by the same fixture are undone in the right order.
    environ = dict(os.environ)
    graph.join(environ)
    for name in os.environ.keys() - environ.keys():
        monkeypatch.delenv(name)
    for name, value in environ.items():
        if os.environ.get(name) != value:
            monkeypatch.setenv(name, value)
    try:
        yield graph
    finally:
        graph.close()
