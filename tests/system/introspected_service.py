"""Service server of ``/add`` with introspection of requests and responses."""

import contextlib

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState


def add(request, response):
    response.sum = request.a + request.b
    return response


rclpy.init()
node = rclpy.create_node("adder")
service = node.create_service(AddTwoInts, "add", add)
service.configure_introspection(
    node.get_clock(), QoSProfile(depth=10), ServiceIntrospectionState.CONTENTS
)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
