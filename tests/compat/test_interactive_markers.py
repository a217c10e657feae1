"""Interactive markers: what clients are sent, and what their feedback does."""

import pytest
from geometry_msgs.msg import Pose
from interactive_markers import InteractiveMarkerServer, MenuHandler
from std_msgs.msg import Header
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from teleopctl.node import Context, Node, SignalHandlerOptions


@pytest.fixture
def server():
    """Server whose updates are kept in a list instead of being published."""
    with Context() as context:
        context.try_shutdown()
        context.init([], signal_handler_options=SignalHandlerOptions.NO)
        node = Node("marked", context=context)
        server = InteractiveMarkerServer(node, "gripper")
        server.sent = []  # type: ignore[attr-defined]
        server._publisher.publish = server.sent.append  # type: ignore[attr-defined, method-assign]
        yield server
        server.shutdown()
        node.destroy_node()


def marker(name="tool"):
    return InteractiveMarker(name=name, header=Header(frame_id="world"))


def pose(x):
    made = Pose()
    made.position.x = x
    return made


def moved(x, client="rviz", name="tool"):
    return InteractiveMarkerFeedback(
        marker_name=name,
        client_id=client,
        event_type=InteractiveMarkerFeedback.POSE_UPDATE,
        pose=pose(x),
        header=Header(frame_id="elsewhere"),
    )


def test_changes_reach_the_clients_together(server):
    server.insert(marker())
    assert server.get("tool").name == "tool"
    assert server.sent == []
    server.applyChanges()
    server.applyChanges()
    assert [(len(each.markers), each.seq_num) for each in server.sent] == [(1, 1)]
    assert server.setPose("tool", pose(1.0))
    assert server.get("tool").pose.position.x == 1.0
    server.applyChanges()
    (sent,) = server.sent[1].poses
    assert (sent.name, sent.pose.position.x, sent.header.frame_id) == ("tool", 1.0, "world")
    assert server.erase("tool")
    assert server.get("tool") is None
    server.applyChanges()
    assert server.sent[2].erases == ["tool"]
    assert not server.setPose("tool", pose(1.0))
    assert not server.erase("tool")


def test_feedback_moves_a_marker_and_calls_its_callback(server):
    seen = []
    server.insert(marker(), feedback_callback=lambda feedback: seen.append(feedback.pose))
    server.applyChanges()
    shown = server._shown["tool"]
    shown.moved_at -= server_second()
    server.processFeedback(moved(2.0))
    assert [each.position.x for each in seen] == [2.0]
    assert server.sent[-1].poses[0].pose.position.x == 2.0
    assert server.sent[-1].poses[0].header.frame_id == "world"  # an unstamped marker stays there
    server.processFeedback(moved(3.0, client="another"))  # within a second: rejected
    server.processFeedback(moved(4.0, name="unknown"))
    assert len(seen) == 1


def server_second():
    from rclpy.duration import Duration

    return Duration(seconds=1.0)


def test_a_menu_calls_the_function_of_the_chosen_entry(server):
    chosen = []
    menu = MenuHandler()
    top = menu.insert("Move")
    home = menu.insert("Home", parent=top, callback=lambda _: chosen.append("home"))
    hidden = menu.insert("Hidden")
    assert top and home and hidden
    assert menu.insert("Lost", parent=99) is None
    assert menu.setVisible(hidden, False)
    assert menu.setCheckState(home, MenuHandler.CHECKED)
    server.insert(marker())
    server.applyChanges()
    assert menu.apply(server, "tool")
    server.applyChanges()
    (shown,) = server.sent[-1].markers
    assert [(each.id, each.parent_id, each.title) for each in shown.menu_entries] == [
        (1, 0, "Move"),
        (2, 1, "[x] Home"),
    ]
    server._shown["tool"].moved_at -= server_second()
    server.processFeedback(
        InteractiveMarkerFeedback(
            marker_name="tool",
            event_type=InteractiveMarkerFeedback.MENU_SELECT,
            menu_entry_id=home,
        )
    )
    assert chosen == ["home"]
    assert not menu.apply(server, "unknown")
    assert menu.reApply(server)
    assert (menu.getTitle(top), menu.getCheckState(home), menu.getTitle(99)) == ("Move", 1, None)
