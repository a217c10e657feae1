"""Node with a parameter of every type, and parameters whose values are hard to write as YAML."""

import contextlib

import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.parameter import Parameter

Type = Parameter.Type

rclpy.init()
node = rclpy.create_node("many", namespace="arm")
node.declare_parameter("bool", True)
node.declare_parameter("bools", [True, False])
node.declare_parameter("bytes", [b"\x00", b"\xff"])
node.declare_parameter("double", 1e22)
node.declare_parameter("doubles", [1.0, -0.5])
node.declare_parameter(
    "limited.double",
    0.5,
    ParameterDescriptor(
        description="Half of it.",
        floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0)],
    ),
)
node.declare_parameter(
    "limited.int",
    4,
    ParameterDescriptor(
        additional_constraints="Even.",
        integer_range=[IntegerRange(from_value=0, to_value=100, step=2)],
    ),
)
node.declare_parameter("free", 1, ParameterDescriptor(dynamic_typing=True))
node.declare_parameter("fixed", 7, ParameterDescriptor(read_only=True))
node.declare_parameter("int", 3)
node.declare_parameter("ints", [1, 2])
node.declare_parameter("no_ints", Type.INTEGER_ARRAY)
node.declare_parameter("none", Type.STRING)
node.set_parameters([Parameter("no_ints", Type.INTEGER_ARRAY, [])])
node.declare_parameter("text", "1e3")
node.declare_parameter("texts", ["yes", "2024-01-01", "# no comment", ""])
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
