"""A node's own ROS arguments beside those of its process."""

from teleopctl.node import Context, Node


def test_a_node_s_own_names_count_before_those_of_the_process(ros):
    del ros
    context = Context()
    context.init(["--ros-args", "-r", "__node:=all", "-r", "__ns:=/everywhere"])
    own = ["--ros-args", "-r", "__node:=page", "-r", "__ns:=/here"]
    try:
        names = [
            Node("page", context=context, cli_args=own).get_fully_qualified_name(),
            Node("other", context=context, cli_args=[]).get_fully_qualified_name(),
        ]
    finally:
        context.try_shutdown()
    assert names == ["/here/page", "/everywhere/all"]
