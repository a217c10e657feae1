"""Parameters with descriptors, ranges and callbacks; ends by itself."""

import rclpy
import rclpy.node
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.exceptions import (
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
)
from rclpy.parameter import Parameter


class Tuned(rclpy.node.Node):
    def __init__(self):
        super().__init__("minimal_param_node")
        descriptor = ParameterDescriptor(
            description="This parameter is mine!", type=ParameterType.PARAMETER_STRING
        )
        self.declare_parameter("my_parameter", "world", descriptor)
        self.declare_parameter(
            "speed",
            1.0,
            ParameterDescriptor(
                floating_point_range=[FloatingPointRange(from_value=0.0, to_value=2.0, step=0.0)]
            ),
        )
        self.declare_parameters(
            namespace="pid",
            parameters=[
                ("p", 1.0),
                ("i", 0.5),
                ("names", ["a", "b"]),
                ("later", Parameter.Type.INTEGER),
            ],
        )
        self.callback_handle = self.add_on_set_parameters_callback(self.on_set)
        self.seen = []
        self.add_post_set_parameters_callback(lambda ps: self.seen.extend(p.name for p in ps))

    def on_set(self, params):
        for param in params:
            if param.name == "my_parameter" and param.value == "bad":
                return SetParametersResult(successful=False, reason="not nice")
        return SetParametersResult(successful=True)


def main(args=None):
    rclpy.init(args=args)
    node = Tuned()
    assert node.get_parameter("my_parameter").get_parameter_value().string_value == "from outside"
    assert node.get_parameter("speed").value == 1.0
    assert node.get_parameter("pid.names").get_parameter_value().string_array_value == ["a", "b"]
    assert set(node.get_parameters_by_prefix("pid")) == {"p", "i", "names", "later"}
    new = Parameter("my_parameter", Parameter.Type.STRING, "earth")
    assert node.set_parameters([new])[0].successful
    refused = node.set_parameters([Parameter("my_parameter", value="bad")])[0]
    assert (refused.successful, refused.reason) == (False, "not nice")
    assert not node.set_parameters([Parameter("speed", value=3.0)])[0].successful
    assert not node.set_parameters_atomically(
        [Parameter("pid.p", value=2.0), Parameter("speed", value=-1.0)]
    ).successful
    assert node.get_parameter("pid.p").value == 1.0
    assert node.seen == ["my_parameter"]
    try:
        node.get_parameter("missing")
        raise AssertionError("no error")
    except ParameterNotDeclaredException:
        pass
    try:
        node.declare_parameter("speed", 2.0)
        raise AssertionError("no error")
    except ParameterAlreadyDeclaredException:
        pass
    step = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=5)])
    try:
        node.declare_parameter("stepped", 3, step)
        raise AssertionError("no error")
    except InvalidParameterValueException:
        pass
    assert node.get_parameter_or("missing", Parameter("missing", value=7)).value == 7
    node.remove_on_set_parameters_callback(node.on_set)
    assert node.set_parameters([Parameter("my_parameter", value="bad")])[0].successful
    assert node.get_parameter_type("speed") == Parameter.Type.DOUBLE
    assert node.describe_parameter("my_parameter").description == "This parameter is mine!"
    node.destroy_node()
    rclpy.shutdown()
    print("done")


if __name__ == "__main__":
    main()
