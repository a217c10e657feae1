"""``joint_state_publisher_gui`` as a real process: states, and a page where there is none."""

import urllib.request

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.packages import package_share
from teleopctl.testing import eventually
from teleopctl.viewer import SLIDERS_TOPIC

JointState = get_message("sensor_msgs/msg/JointState")
MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
LINE = f"run joint_state_publisher_gui joint_state_publisher_gui {MODEL} --port 0"


class Listener:
    """Hears the joints, and speaks as sliders do."""

    def __init__(self, name):
        self.context = Context()
        self.context.init([])
        self.node = Node(name, context=self.context)
        self.joints: dict[str, float] = {}
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.node.create_subscription(JointState, "/joint_states", self._take, 10)
        self.sliders = self.node.create_publisher(JointState, SLIDERS_TOPIC, 10)

    def _take(self, state):
        self.joints.update(zip(state.name, state.position, strict=True))

    def hears(self, **wanted):
        """Spin once, and tell whether joints are where they should be."""
        self.executor.spin_once(0.05)
        return all(self.joints.get(name) == value for name, value in wanted.items())


@pytest.fixture
def listen(ros):
    del ros
    made = []

    def make(name):
        made.append(Listener(name))
        return made[-1]

    yield make
    for one in made:
        one.context.try_shutdown()


def test_it_publishes_the_joints_and_serves_the_sliders_on_a_page(ros, listen):
    listener = listen("listener")
    gui = ros.spawn(f"{LINE} --ros-args -r __node:=gui -p zeros.joint_1:=0.5")
    eventually(lambda: listener.hears(joint_1=0.5, joint_5=0.0))
    listener.node.wait_for_subscribers(SLIDERS_TOPIC, 1, 20.0)
    listener.sliders.publish(JointState(name=["joint_4"], position=[-1.0]))
    eventually(lambda: listener.hears(joint_1=0.5, joint_4=-1.0, joint_5=1.0))
    address = gui.wait_for_line(r"The sliders are at (http://localhost:\d+/)")[1]
    with urllib.request.urlopen(address, timeout=10) as page:
        assert page.status == 200
    assert listener.node.wait_for_node("/rviz", 20.0)
    assert listener.node.wait_for_node("/gui", 20.0)


def test_where_a_page_runs_it_listens_to_that_one(ros, listen):
    page = listen("rviz2")
    gui = ros.spawn(LINE)
    gui.wait_for_line("The sliders are in the panel Joints of the page that /rviz2 serves")
    page.sliders.publish(JointState(name=["joint_1"], position=[1.0]))
    eventually(lambda: page.hears(joint_1=1.0))
    names = page.node.get_fully_qualified_node_names()
    assert sorted(names) == ["/joint_state_publisher_gui", "/rviz2"]
