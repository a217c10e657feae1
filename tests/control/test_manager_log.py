"""Errors of a controller manager, as commands read them from ``/rosout``."""

from typing import Any

from teleopctl.control.manager_log import ManagerLog
from teleopctl.interfaces import get_message
from teleopctl.node import LoggingSeverity
from teleopctl.testing import RecordedNode

Log = get_message("rcl_interfaces/msg/Log")
ERROR = "Loader for controller 'arm' (type 'vendor/Special') not found."


class LateNode(RecordedNode):
    """A node whose first subscription misses a line that the publisher keeps for later ones."""

    def create_subscription(self, msg_type, topic, callback, qos_profile, *, immediate=False):
        if topic in self.endpoints:
            line = Log(level=int(LoggingSeverity.ERROR), name="controller_manager", msg=ERROR)
            callback(line)
        return super().create_subscription(
            msg_type, topic, callback, qos_profile, immediate=immediate
        )


def test_an_error_that_was_logged_before_the_subscription_was_known_is_found():
    node: Any = LateNode("spawner")
    log = ManagerLog(node, "/controller_manager")
    assert log.cause("arm", 0) == ERROR
    assert log.last_error("Loader for", 0) == ERROR.removeprefix("Loader for").strip()
