"""A control stack without ROS: real classes around a node that only remembers."""

import copy
from types import SimpleNamespace

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controllers.base import ControllerInterfaceParams
from teleopctl.control.cycle import Cycle
from teleopctl.control.lifecycle import State
from teleopctl.control.realtime_publisher import PublishQueue
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.robot.description import RobotDescription

START = 1_000_000_000_000


class Log:
    """Collects log lines by severity."""

    def __init__(self, name="test"):
        self.lines = []
        self.name = name

    def _add(self, severity, text):
        self.lines.append((severity, text))

    def info(self, text, **_):
        self._add("info", text)

    def warning(self, text, **_):
        self._add("warning", text)

    def error(self, text, **_):
        self._add("error", text)

    def get_child(self, name):
        del name
        return self

    def texts(self, severity=None):
        return [text for kind, text in self.lines if severity in (None, kind)]


class Endpoint:
    """A publisher or subscription that remembers."""

    def __init__(self, topic, callback=None):
        self.topic = topic
        self.callback = callback
        self.messages = []

    def publish(self, message):
        # What is sent stays as it was, whatever the sender does with its message.
        self.messages.append(copy.deepcopy(message))

    def get_subscription_count(self):
        return 1


class FakeNode:
    """As much of a node as controllers use."""

    def __init__(self, name, parameters=None):
        self.name = name
        self.parameters = dict(parameters or {})
        self.endpoints = {}
        self.log = Log(name)
        self.post_set = []

    def get_logger(self):
        return self.log

    def has_parameter(self, name):
        return name in self.parameters

    def declare_parameter(self, name, default, descriptor=None):
        del descriptor
        self.parameters[name] = default

    def get_parameter(self, name):
        return SimpleNamespace(value=self.parameters[name])

    def set(self, **values):
        for name, value in values.items():
            self.parameters[name.replace("__", ".")] = value
        for callback in self.post_set:
            callback([])

    def add_post_set_parameters_callback(self, callback):
        self.post_set.append(callback)

    def create_publisher(self, kind, topic, qos):
        del kind, qos
        return self.endpoints.setdefault(topic, Endpoint(topic))

    def create_subscription(self, kind, topic, callback, qos, **_):
        del kind, qos
        return self.endpoints.setdefault(topic, Endpoint(topic, callback))

    def create_service(self, kind, topic, callback):
        del kind
        return self.endpoints.setdefault(topic, Endpoint(topic, callback))

    def _destroy(self, endpoint):
        self.endpoints.pop(endpoint.topic, None)

    destroy_publisher = destroy_subscription = destroy_service = _destroy

    def receive(self, topic, message):
        self.endpoints[topic].callback(message)


def urdf(
    joints=3,
    *,
    initial=(1.1, 2.1, 3.1),
    commands=("position",),
    states=("position",),
    parameters="",
    plugin="mock_components/GenericSystem",
    kind="revolute",
    limits='lower="-100" upper="100" effort="1000" velocity="1000"',
    extra_joints="",
    extra_control="",
):
    """A robot of joints in a row with one hardware component."""
    names = [f"joint{number}" for number in range(1, joints + 1)]
    links = "".join(f'<link name="link{number}"/>' for number in range(joints + 1))
    body = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="link{number}"/>'
        f'<child link="link{number + 1}"/><axis xyz="0 0 1"/><limit {limits}/></joint>'
        for number, name in enumerate(names)
    )

    def state(name, value):
        text = f'<param name="initial_value">{value}</param>' if name == "position" else ""
        return f'<state_interface name="{name}">{text}</state_interface>'

    control = "".join(
        f'<joint name="{name}">'
        + "".join(f'<command_interface name="{command}"/>' for command in commands)
        + "".join(state(one, initial[number % len(initial)]) for one in states)
        + "</joint>"
        for number, name in enumerate(names)
    )
    return (
        f'<robot name="test">{links}{body}{extra_joints}'
        f'<ros2_control name="Hardware" type="system"><hardware><plugin>{plugin}</plugin>'
        f"{parameters}</hardware>{control}{extra_control}</ros2_control></robot>"
    )


class Stack:
    """Hardware, manager and cycle; time passes when a test says so."""

    def __init__(self, text=None, *, update_rate=100, parameters=None, enforce_limits=True):
        self.log = Log("controller_manager")
        self.node = FakeNode("controller_manager", parameters)
        self.controller_parameters = {}
        self.nodes = {}
        self.changes = 0
        self.time_ns = START
        self.resources = ResourceManager(
            self.node, self.log, lambda text: self.cycle.report(text), enforce_limits=enforce_limits
        )
        self.publish_queue = PublishQueue(self.log.warning)
        self.manager = ControllerManager(self.resources, self, self.log, update_rate)
        self.cycle = Cycle(self.manager, self.publish_queue)
        if text is not None:
            self.load(text)

    def load(self, text):
        self.description = RobotDescription.from_urdf(text)
        self.resources.load_and_initialize_components(self.description)
        for component in self.resources.components.values():
            component.change_state(State.ACTIVE)

    # what the manager asks of its node

    def parameter(self, name):
        return self.node.parameters.get(name)

    def create_controller_params(self, controller_name):
        node = FakeNode(controller_name, self.controller_parameters.get(controller_name))
        self.nodes[controller_name] = node
        return ControllerInterfaceParams(
            controller_name=controller_name,
            node=node,
            update_rate=float(self.manager.update_rate),
            joint_limits=self.resources.limits,
            continuous_joints=frozenset(
                joint.name
                for joint in self.description.joints.values()
                if joint.type == "continuous"
            ),
            robot_description=self.description.urdf,
            publish_queue=self.publish_queue,
            now_ns=lambda: self.time_ns,
        )

    def destroy_controller_node(self, node):
        del self.nodes[node.name]

    def publish_activity(self):
        self.changes += 1

    # what tests do

    def add(self, name, type_name, **parameters):
        self.node.parameters[f"{name}.type"] = type_name
        self.controller_parameters[name] = {
            key.replace("__", "."): value for key, value in parameters.items()
        }
        assert self.manager.load_controller(name)
        return self.manager.controllers[name].controller

    def step(self, count=1, period_ns=None):
        for _ in range(count):
            self.time_ns += period_ns or round(1e9 / self.manager.update_rate)
            self.cycle.run(self.time_ns)

    def step_until(self, seconds):
        """Run cycles until so many seconds after the start of the test's clock."""
        while self.time_ns < START + round(seconds * 1e9):
            self.step()

    def commands(self, interface="position"):
        return [
            command.value
            for command in self.resources.command_interfaces.values()
            if command.interface_name == interface
        ]
