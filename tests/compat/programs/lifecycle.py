"""A node that offers the services of a life cycle by hand; each transition succeeds."""

import contextlib

import rclpy
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

STATES = {
    Transition.TRANSITION_CONFIGURE: ("configuring", "inactive"),
    Transition.TRANSITION_ACTIVATE: ("activating", "active"),
    Transition.TRANSITION_DEACTIVATE: ("deactivating", "inactive"),
}


class Lively(Node):
    def __init__(self):
        super().__init__("lively")
        self.events = self.create_publisher(TransitionEvent, "~/transition_event", 10)
        self.create_service(ChangeState, "~/change_state", self.change)

    def change(self, request, response):
        response.success = request.transition.id in STATES
        if response.success:
            event = TransitionEvent()
            event.start_state.label, event.goal_state.label = STATES[request.transition.id]
            event.transition.label = f"on_{request.transition.id}"
            self.events.publish(event)
        return response


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Lively())
