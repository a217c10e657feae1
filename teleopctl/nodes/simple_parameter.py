"""The tutorial's parameter node: two parameters, and a callback that says when one changes.

An ordinary ROS 2 source: it runs unchanged with rclpy too.
"""

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


class SimpleParameter(Node):
    """Declares ``simple_int_param`` and ``simple_string_param`` and reports their changes."""

    def __init__(self) -> None:
        super().__init__("simple_parameter")
        self.declare_parameter("simple_int_param", 28)
        self.declare_parameter("simple_string_param", "Antonio")
        self.add_on_set_parameters_callback(self._on_change)

    def _on_change(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            self.get_logger().info(
                f"Param {parameter.name} changed! New value is {parameter.value}"
            )
        return SetParametersResult(successful=True)


def main(args: list[str] | None = None) -> None:
    """Run the node until it is interrupted."""
    rclpy.init(args=args)
    node = SimpleParameter()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or a launch file's shutdown: the ordinary end of this node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
