"""Demos of parameters: a blackboard, a client of it, and callbacks around a change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import rclpy
from ament_index_python import get_package_share_path
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import (
    Parameter,
    parameter_dict_from_yaml_file,
    parameter_value_to_python,
)
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from teleopctl.nodes.demos import run

_WAIT_S = 3.0
_SET = ["int_parameter", "bool_parameter", "string_parameter"]
_DELETED = ["other_int_parameter", "other_string_parameter", "string_parameter"]
_DEPTH = 10
_SECOND_VALUE = 4.0


class ParameterBlackboard(Node):
    """Node ``parameter_blackboard``, which accepts any parameter without declaration."""

    def __init__(self) -> None:
        super().__init__(
            "parameter_blackboard",
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        count = len(self.list_parameters([], 0).names)
        self.get_logger().info(
            f"Parameter blackboard node named '{self.get_fully_qualified_name()}' ready, and "
            f"serving '{count}' parameters already!"
        )


class SetParametersCallback(Node):
    """Node that sets ``param2`` to 4.0 whenever ``param1`` is set, and stores both values."""

    def __init__(self) -> None:
        super().__init__("set_parameters_callback")
        self._tracked = {
            name: self.declare_parameter(name, 0.0).value for name in ("param1", "param2")
        }
        self.add_pre_set_parameters_callback(self._complete)
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._track)

    def _complete(self, parameters: list[Parameter]) -> list[Parameter]:
        second = Parameter("param2", Parameter.Type.DOUBLE, _SECOND_VALUE)
        return parameters + [second for each in parameters if each.name == "param1"]

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        result = SetParametersResult()
        for parameter in parameters:
            if parameter.name in self._tracked:
                result = SetParametersResult(successful=True, reason=f"success {parameter.name}")
        return result

    def _track(self, parameters: list[Parameter]) -> None:
        self._tracked.update(
            (each.name, each.value) for each in parameters if each.name in self._tracked
        )


def parameter_blackboard(args: list[str] | None = None) -> None:
    """Run the node ``parameter_blackboard``, which accepts any parameter, until Ctrl-C."""
    run(ParameterBlackboard, args)


def set_parameters_callback(args: list[str] | None = None) -> None:
    """Run `SetParametersCallback` as ``demo_nodes_py set_parameters_callback`` until Ctrl-C."""
    run(SetParametersCallback, args)


def async_param_client(args: list[str] | None = None) -> None:
    """Run ``async_param_client``, which sets, reads and deletes parameters of a blackboard node.

    Raises:
        RuntimeError: No node ``parameter_blackboard`` was found within 3 s.
    """
    rclpy.init(args=args)
    node = rclpy.create_node("async_param_client")
    try:
        client = AsyncParameterClient(node, "parameter_blackboard")
        if not client.wait_for_services(_WAIT_S):
            raise RuntimeError(
                "parameter_blackboard is not available, start parameter blackboard with "
                "`ros2 run demo_nodes_cpp parameter_blackboard` before running this demo"
            )
        _Steps(node, client).run()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C while waiting for a response
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


class _Steps:
    """Steps of the demo client, with their log lines."""

    def __init__(self, node: Node, client: AsyncParameterClient) -> None:
        self._node = node
        self._client = client
        self._say = node.get_logger().info

    def run(self) -> None:
        """Set, list, get, load and delete parameters of the blackboard, and log each result."""
        self._say("Setting parameters:")
        values = [
            Parameter("int_parameter", Parameter.Type.INTEGER, 10),
            Parameter("bool_parameter", Parameter.Type.BOOL, False),
            Parameter("string_parameter", Parameter.Type.STRING, "Fee Fi Fo Fum"),
        ]
        done = self._done(self._client.set_parameters(values))
        self._log_results(_SET, done.results)
        self._say("Listing Parameters:")
        for name in self._done(self._client.list_parameters(_SET, _DEPTH)).result.names:
            self._say(f"    - {name}")
        self._say("Getting parameters:")
        got = self._done(self._client.get_parameters(_SET)).values
        for name, value in zip(_SET, got, strict=True):
            self._say(f"    - {name}: {parameter_value_to_python(value)}")
        self._say("Loading parameters: ")
        file = str(get_package_share_path("demo_nodes_py") / "params.yaml")
        results = self._done(self._client.load_parameter_file(file)).results
        loaded = parameter_dict_from_yaml_file(file)
        for (name, parameter), result in zip(loaded.items(), results, strict=True):
            self._log_results([name], [result])
            self._say(f"        value: {parameter_value_to_python(parameter.value)}")
        self._say("Deleting parameters: ")
        results = self._done(self._client.delete_parameters(_DELETED)).results
        for name, result in zip(_DELETED, results, strict=True):
            self._log_results([name], [result])
            self._say(f"        reason: {result.reason}")

    # Any: results of the services of rcl_interfaces.
    def _log_results(self, names: Sequence[str], results: Sequence[Any]) -> None:
        for name, result in zip(names, results, strict=True):
            self._say(f"    {name}:")
            self._say(f"        successful: {result.successful}")

    def _done(self, future: Future[Any]) -> Any:
        rclpy.spin_until_future_complete(self._node, future)
        return future.result()  # raises the exception of a failed call
