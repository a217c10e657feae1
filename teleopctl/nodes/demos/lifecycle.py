"""Demo of lifecycle nodes: a managed talker, its listener, and a client of its transitions."""

from __future__ import annotations

import time

import rclpy
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import Node, Publisher, State, TransitionCallbackReturn
from rclpy.node import Node as PlainNode
from rclpy.timer import Timer
from std_msgs.msg import String

from teleopctl.nodes.demos import run

_PERIOD_S = 1.0
_TALKER = "lc_talker"
_WAIT_S = 10.0
_BETWEEN_S = 10.0
_TRANSITIONS = (
    Transition.TRANSITION_CONFIGURE,
    Transition.TRANSITION_ACTIVATE,
    Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_ACTIVATE,
    Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_CLEANUP,
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN,
)


class LifecycleTalker(Node):
    """Lifecycle node that publishes on ``lifecycle_chatter`` once a second while active.

    While the node is inactive, its lifecycle publisher drops the messages.
    """

    def __init__(self, node_name: str) -> None:
        self._count = 0
        self._publisher: Publisher[String] | None = None
        self._timer: Timer | None = None
        super().__init__(node_name)

    def on_configure(self, state: State) -> TransitionCallbackReturn:
        """Create the publisher and its timer; called on the transition ``configure``."""
        del state
        self._publisher = self.create_lifecycle_publisher(String, "lifecycle_chatter", 10)
        self._timer = self.create_timer(_PERIOD_S, self._publish)
        self.get_logger().info("on_configure() is called.")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: State) -> TransitionCallbackReturn:
        """Log, and enable the publisher by the base class; called on ``activate``."""
        self.get_logger().info("on_activate() is called.")
        return super().on_activate(state)

    def on_deactivate(self, state: State) -> TransitionCallbackReturn:
        """Log, and disable the publisher by the base class; called on ``deactivate``."""
        self.get_logger().info("on_deactivate() is called.")
        return super().on_deactivate(state)

    def on_cleanup(self, state: State) -> TransitionCallbackReturn:
        """Destroy the publisher and its timer; called on the transition ``cleanup``."""
        del state
        self._destroy_publisher()
        self.get_logger().info("on_cleanup() is called.")
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: State) -> TransitionCallbackReturn:
        """Destroy the publisher and its timer; called on the transition ``shutdown``."""
        del state
        self._destroy_publisher()
        self.get_logger().info("on_shutdown() is called.")
        return TransitionCallbackReturn.SUCCESS

    def _publish(self) -> None:
        message = String(data=f"Lifecycle HelloWorld #{self._count}")
        self._count += 1
        if self._publisher is None or not self._publisher.is_activated:
            self.get_logger().info("Lifecycle publisher is inactive. Messages are not published.")
        else:
            self.get_logger().info(f"Lifecycle publisher is active. Publishing: [{message.data}]")
        if self._publisher is not None:
            self._publisher.publish(message)

    def _destroy_publisher(self) -> None:
        if self._timer is not None:
            self.destroy_timer(self._timer)
        if self._publisher is not None:
            self.destroy_publisher(self._publisher)
        self._timer = self._publisher = None


def lifecycle_talker(args: list[str] | None = None) -> None:
    """Run the lifecycle node ``lc_talker``, which publishes while active, until Ctrl-C."""
    rclpy.init(args=args)
    node = LifecycleTalker(_TALKER)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end of this node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


class LifecycleListener(PlainNode):
    """Node that logs the messages of ``lc_talker`` and the transitions of its lifecycle."""

    def __init__(self) -> None:
        super().__init__("lc_listener")
        self.create_subscription(String, "/lifecycle_chatter", self._log_message, 10)
        self.create_subscription(
            TransitionEvent, f"/{_TALKER}/transition_event", self._log_transition, 10
        )

    def _log_message(self, message: String) -> None:
        self.get_logger().info(f"data_callback: {message.data}")

    def _log_transition(self, event: TransitionEvent) -> None:
        start, goal = event.start_state.label, event.goal_state.label
        self.get_logger().info(f"notify callback: Transition from state {start} to {goal}")


def lifecycle_listener(args: list[str] | None = None) -> None:
    """Run the node ``lc_listener`` until Ctrl-C: it logs messages and transitions of the talker."""
    run(LifecycleListener, args)


def lifecycle_service_client(args: list[str] | None = None) -> None:
    """Run the node ``lc_client``: it takes the talker through its lifecycle, then exits."""
    rclpy.init(args=args)
    node = PlainNode("lc_client")
    try:
        _manage(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C between two transitions
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _manage(node: PlainNode) -> None:
    change = node.create_client(ChangeState, f"{_TALKER}/change_state")
    get = node.create_client(GetState, f"{_TALKER}/get_state")
    for number, transition in enumerate(_TRANSITIONS):
        if number:
            time.sleep(_BETWEEN_S)
        for client in (change, get):
            if not client.wait_for_service(timeout_sec=_WAIT_S):
                node.get_logger().error(f"Service {client.service_name} is not available.")
                return
        changed = change.call_async(ChangeState.Request(transition=Transition(id=transition)))
        rclpy.spin_until_future_complete(node, changed)
        response = changed.result()
        if response is None or not response.success:
            node.get_logger().warning(f"Failed to trigger transition {transition}")
            return
        node.get_logger().info(f"Transition {transition} successfully triggered.")
        found = get.call_async(GetState.Request())
        rclpy.spin_until_future_complete(node, found)
        state = found.result()
        if state is not None:
            label = state.current_state.label
            node.get_logger().info(f"Node {_TALKER} has current state {label}.")
