"""A user's node without type errors; `test_mypy` adds lines with type errors."""

from __future__ import annotations

import rclpy
from example_interfaces.srv import AddTwoInts
from geometry_msgs.msg import PoseWithCovariance
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.task import Future
from sensor_msgs.msg import BatteryState, JointState
from std_msgs.msg import Header, String
from tf2_ros import Buffer, TransformListener


class Talker(Node):
    """Node with every kind of endpoint."""

    def __init__(self) -> None:
        super().__init__("talker")
        self.publisher: Publisher[String] = self.create_publisher(String, "chatter", 10)
        self.states = self.create_subscription(JointState, "joint_states", self.hear, 10)
        self.words = self.create_subscription(String, "words", self.later, 10)
        self.bytes = self.create_subscription(
            String, "words", self.take, rclpy.qos.qos_profile_sensor_data, raw=True
        )
        self.adder = self.create_client(AddTwoInts, "add")
        self.server = self.create_service(AddTwoInts, "add", self.add)
        self.timer = self.create_timer(1.0, self.tick)
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        speed = self.declare_parameter("speed", 1.0, ParameterDescriptor(read_only=True))
        self.speed: float = speed.value
        self.place: str = self.get_parameter("place").get_parameter_value().string_value
        self.add_on_set_parameters_callback(self.accept)

    def accept(self, parameters: list[Parameter]) -> SetParametersResult:
        names = ", ".join(parameter.name for parameter in parameters)
        return SetParametersResult(successful=True, reason=names)

    def hear(self, message: JointState) -> None:
        message.header.stamp = self.get_clock().now().to_msg()
        total: float = sum(message.position)
        self.publisher.publish(String(data=f"{message.name[0]}: {total}"))

    async def later(self, message: String) -> None:
        answer = await self.adder.call_async(AddTwoInts.Request(a=1, b=len(message.data)))
        if answer is not None:
            self.get_logger().info(f"{answer.sum}")

    def take(self, data: bytes) -> None:
        self.publisher.publish(data)

    def add(
        self, request: AddTwoInts.Request, response: AddTwoInts.Response
    ) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response

    def tick(self) -> None:
        self.adder.call_async(AddTwoInts.Request(a=1, b=2)).add_done_callback(self.tell)

    def tell(self, future: Future[AddTwoInts.Response]) -> None:
        answer = future.result()
        self.get_logger().info("nothing" if answer is None else str(answer.sum))


def values() -> None:
    """Assign values to message fields and read fields, with the types of the stubs."""
    state = JointState(header=Header(frame_id="base"), name=["a", "b"], position=[1, 2.5])
    state.velocity = (velocity * 2 for velocity in state.position)
    state.position.append(3.0)
    state.name = {"a": 1}.keys()
    pose = PoseWithCovariance()
    pose.covariance[0] = 0.1
    pose.pose.orientation.w = 1.0
    battery = BatteryState(power_supply_status=BatteryState.POWER_SUPPLY_STATUS_FULL)
    battery.present = True


def main() -> None:
    """Run the node."""
    rclpy.init()
    node = Talker()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
