"""Marks of a bag: warnings, first touches, episodes."""

from teleopctl.bag import BagWriter
from teleopctl.interfaces import get_message
from teleopctl.nodes.bag_marks import bag_marks
from tests.bag.bags import message, topic

LOG, CONTACTS = "rcl_interfaces/msg/Log", "ros_gz_interfaces/msg/Contacts"
STATUS = "diagnostic_msgs/msg/DiagnosticStatus"


def test_warnings_first_touches_and_episodes_are_marked(tmp_path):
    contact, entity = (
        get_message(f"ros_gz_interfaces/msg/{name}") for name in ("Contact", "Entity")
    )
    touch = [contact(collision1=entity(name="cube"), collision2=entity(name="table"))]
    state = "/episode_recorder/state"
    written = [
        message("/rosout", 0, LOG, level=20, name="arm", msg="all is well"),
        message("/contacts", 1, CONTACTS, contacts=[]),
        message("/contacts", 2, CONTACTS, contacts=touch),
        message("/contacts", 3, CONTACTS, contacts=touch),
        message(state, 4, STATUS, message="recording"),
        message(state, 5, STATUS, message="recording"),
        message("/rosout", 6, LOG, level=30, name="arm", msg="joint is hot"),
        message("/rosout", 7, LOG, level=40, name="arm", msg="joint is lost"),
    ]
    with BagWriter(tmp_path / "bag") as writer:
        for name, kind in (("/rosout", LOG), ("/contacts", CONTACTS), (state, STATUS)):
            writer.add_topic(topic(name, kind))
        for one in written:
            writer.write(one)
    assert [(mark.kind, mark.text) for mark in bag_marks(tmp_path / "bag")] == [
        ("contact", "cube and table"),
        ("episode", "recording"),
        ("warning", "arm: joint is hot"),
        ("error", "arm: joint is lost"),
    ]
