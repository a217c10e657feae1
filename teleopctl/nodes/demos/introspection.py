"""Demo of service introspection: a service and a client that publish what they exchange.

``ros2 param set /introspection_client client_configure_introspection contents`` (or ``metadata``)
enables introspection of the client, and ``/introspection_service service_configure_introspection``
of the service; ``service echo /add_two_ints`` shows the events.
"""

from __future__ import annotations

import rclpy
from example_interfaces.srv import AddTwoInts
from rcl_interfaces.msg import SetParametersResult
from rclpy.client import Client
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_system_default
from rclpy.service import Service
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.task import Future

from teleopctl.nodes.demos import run

_STATES = {
    "disabled": ServiceIntrospectionState.OFF,
    "metadata": ServiceIntrospectionState.METADATA,
    "contents": ServiceIntrospectionState.CONTENTS,
}
_PERIOD_S = 0.5


class _Introspected(Node):
    """A node with a parameter that sets how much of its service's calls is published."""

    endpoint: (
        Client[AddTwoInts.Request, AddTwoInts.Response]
        | Service[AddTwoInts.Request, AddTwoInts.Response]
    )

    def _offer_switch(self, name: str) -> None:
        self._switch = name
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._apply)
        self.declare_parameter(name, "disabled")

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name != self._switch:
                continue
            if parameter.type_ != Parameter.Type.STRING:
                return SetParametersResult(successful=False, reason="must be a string")
            if parameter.value not in _STATES:
                reason = "must be one of 'disabled', 'metadata', or 'contents"
                return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    def _apply(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == self._switch:
                self.endpoint.configure_introspection(
                    self.get_clock(), qos_profile_system_default, _STATES[str(parameter.value)]
                )


class IntrospectionService(_Introspected):
    """Node that serves ``add_two_ints``; a parameter sets its service introspection state."""

    def __init__(self) -> None:
        super().__init__("introspection_service")
        self.endpoint = self.create_service(AddTwoInts, "add_two_ints", self._add)
        self._offer_switch("service_configure_introspection")

    def _add(
        self, request: AddTwoInts.Request, response: AddTwoInts.Response
    ) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        self.get_logger().info(f"Incoming request\na: {request.a} b: {request.b}")
        return response


class IntrospectionClient(_Introspected):
    """Node that calls ``add_two_ints`` twice a second; a parameter sets its introspection state."""

    def __init__(self) -> None:
        super().__init__("introspection_client")
        self._client = self.create_client(AddTwoInts, "add_two_ints")
        self.endpoint = self._client
        self._offer_switch("client_configure_introspection")
        self._future: Future[AddTwoInts.Response] | None = None
        self._timer = self.create_timer(_PERIOD_S, self._call)

    def _call(self) -> None:
        if not self._client.service_is_ready():
            return
        if self._future is None:
            self._future = self._client.call_async(AddTwoInts.Request(a=2, b=3))
        elif self._future.done():
            response = self._future.result()
            if response is not None:
                self.get_logger().info(f"Result of add_two_ints: {response.sum}")
            else:
                self.get_logger().error(f"Exception calling service: {self._future.exception()!r}")
            self._future = None


def introspection_service(args: list[str] | None = None) -> None:
    """Run the node ``introspection_service`` until Ctrl-C."""
    run(IntrospectionService, args)


def introspection_client(args: list[str] | None = None) -> None:
    """Run the node ``introspection_client`` until Ctrl-C."""
    run(IntrospectionClient, args)


def introspection(args: list[str] | None = None) -> None:
    """Run the service introspection demo, server and client node, until Ctrl-C."""
    rclpy.init(args=args)
    nodes = (IntrospectionService(), IntrospectionClient())
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end of these nodes
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
