"""What ROS 2's security variables forbid, with real commands and nodes."""

import logging
import sys

import pytest

from teleopctl.errors import UnsupportedError
from teleopctl.wire import open_session, security
from teleopctl.wire.config import router_config
from teleopctl.wire.security import check_security
from teleopctl.wire.session import open_zenoh

ENABLE = "ROS_SECURITY_ENABLE"
STRATEGY = "ROS_SECURITY_STRATEGY"
REFUSAL = "ROS_SECURITY_STRATEGY=Enforce forbids to communicate without keys"


@pytest.fixture(autouse=True)
def _first_time(monkeypatch):
    monkeypatch.setattr(security, "_warned", set())


@pytest.fixture
def security_of(monkeypatch):
    def set_to(enable, strategy=None):
        for name, value in ((ENABLE, enable), (STRATEGY, strategy)):
            if value is None:
                monkeypatch.delenv(name, raising=False)
            else:
                monkeypatch.setenv(name, value)

    return set_to


@pytest.fixture
def enforced(ros, monkeypatch):
    monkeypatch.setitem(ros.env, ENABLE, "true")
    monkeypatch.setitem(ros.env, STRATEGY, "Enforce")
    return ros


def test_where_security_is_enforced_no_session_and_no_router_is_opened(ros, security_of):
    del ros
    security_of("true", "Enforce")
    with pytest.raises(UnsupportedError, match=REFUSAL):
        open_session("client")
    with pytest.raises(UnsupportedError, match=REFUSAL):
        open_session("peer")
    with pytest.raises(UnsupportedError, match=REFUSAL):
        open_zenoh(router_config().zenoh)


# rcl compares both letter by letter; the last is its default where there is no strategy.
@pytest.mark.parametrize("strategy", ["Permissive", "enforce", "", None])
def test_where_security_is_only_wanted_each_process_warns_once(security_of, caplog, strategy):
    security_of("true", strategy)
    check_security()
    check_security()
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "nothing is encrypted or authenticated" in record.message


@pytest.mark.parametrize("enable", [None, "", "false", "0"])
def test_where_security_is_off_nothing_is_said(security_of, caplog, enable):
    security_of(enable, "Enforce")
    check_security()
    assert not caplog.records


@pytest.mark.parametrize("enable", ["True", "TRUE", "1", "yes"])
def test_a_spelling_that_rcl_takes_for_off_is_warned_of(security_of, caplog, enable):
    security_of(enable, "Enforce")
    check_security()
    (record,) = caplog.records
    assert f"{ENABLE} is {enable!r}, which ROS 2 treats as off" in record.message


@pytest.mark.parametrize(
    "words",
    [
        "topic list",
        "topic echo /chatter",
        "run demo_nodes_py talker",
        "launch display.yaml",
        "bag record -a",
        "daemon start",
    ],
)
def test_a_command_that_would_be_in_the_open_is_refused(enforced, words):
    done = enforced.run(words.split())
    assert done.returncode == 2
    assert done.stderr.startswith(f"teleopctl: {REFUSAL}")
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_a_message_is_not_published_in_the_open(enforced):
    done = enforced.run(["topic", "pub", "--once", "/x", "std_msgs/msg/String", "{data: a}"])
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"teleopctl: {REFUSAL}")


def test_a_program_of_ones_own_is_refused_where_it_makes_its_node(enforced, tmp_path):
    path = tmp_path / "open.py"
    path.write_text("import rclpy\nrclpy.init()\nrclpy.create_node('open')\nprint('open')\n")
    program = enforced.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    assert program.wait() != 0
    assert REFUSAL in program.stderr
    assert program.stdout == ""
