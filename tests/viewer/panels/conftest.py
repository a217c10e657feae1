"""Fixture: page in a ROS graph."""

from collections.abc import Iterator

import pytest
from viser import ViserServer

from teleopctl.testing import RosGraph
from tests.viewer.panels.live import LivePage


@pytest.fixture
def live(page_server: ViserServer, ros: RosGraph) -> Iterator[LivePage]:
    """Fixture: page of one test in the test's own graph."""
    del ros
    page = LivePage(page_server)
    yield page
    page.close()
