"""From which port a session is connected, as the router tells it."""

import os

import psutil
import pytest

from teleopctl.wire.connections import _ports, session_ports
from teleopctl.wire.session import open_session


def test_the_port_of_a_session_is_one_of_its_process(ros):
    with open_session("client") as session:
        (port,) = session_ports(session)[str(session.zid())]
        own = psutil.Process(os.getpid()).net_connections("tcp")
        assert port in {connection.laddr.port for connection in own if connection.laddr}


@pytest.mark.parametrize(
    "report",
    [
        b"",
        b"nonsense",
        b"[]",
        b'{"sessions": 1}',
        b'{"sessions": [{"peer": "a"}]}',
        b'{"sessions": [{"peer": "a", "links": [{"dst": "tcp/nowhere"}]}]}',
        b'{"sessions": [{"peer": "a", "links": [1]}]}',
        b'{"sessions": [{"peer": "a", "links": [{"dst": 7}]}]}',
    ],
)
def test_a_report_of_another_form_tells_nothing(report):
    assert _ports(report) == []
