"""Pages on a graph."""

from collections.abc import Iterator

import pytest
from viser import ViserServer

from teleopctl.testing import RosGraph
from tests.viewer.panels.live import LivePage


@pytest.fixture
def live(page_server: ViserServer, ros: RosGraph) -> Iterator[LivePage]:
    """A page of the test's own on a graph of the test's own."""
    del ros
    page = LivePage(page_server)
    yield page
    page.close()
