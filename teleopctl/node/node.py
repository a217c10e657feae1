"""ROS nodes, with rclpy's methods."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.context import Context
from teleopctl.node.node_options import take_next_options
from teleopctl.node.node_parameters import NodeParameters
from teleopctl.node.values.logging import set_logger_level
from teleopctl.node.values.parameter import Parameter
from teleopctl.node.values.qos import QoSProfile, as_qos_profile, qos_profile_rosout_default

if TYPE_CHECKING:
    from teleopctl.node.node_services import RosoutPublisher

LOGGER_SERVICES = "TELEOPCTL_LOGGER_SERVICES"
"""Environment variable that turns on the logger services of every node whose name is not hidden."""


class Node(NodeParameters):
    """ROS node with rclpy's methods; `teleopctl.open_node` starts one.

    Args:
        node_name: Name of the node, unless ``__node`` is remapped.
        context: Context of the node; the default context if None.
        cli_args: Command-line arguments of the node, with ``--ros-args`` groups.
        namespace: Namespace of the node, unless ``__ns`` is remapped.
        use_global_arguments: Whether the command-line arguments of ``init()`` apply.
        enable_rosout: Whether log messages are published on ``/rosout``.
        rosout_qos_profile: QoS of ``/rosout``.
        start_parameter_services: Whether other nodes can read and set the parameters.
        parameter_overrides: Parameter values that take precedence over declared defaults and the
            command line, as in rclpy.
        allow_undeclared_parameters: Whether undeclared parameters can be set.
        automatically_declare_parameters_from_overrides: Whether parameters in the overrides are
            declared.
        enable_logger_service: Whether ``~/get_logger_levels`` and ``~/set_logger_levels`` are
            offered; `LOGGER_SERVICES` turns them on as well.

    Raises:
        NotInitializedException: The context is not initialized.
        InvalidNodeNameException: The name is malformed.
        InvalidNamespaceException: The namespace is malformed.

    Example:
        >>> import teleopctl
        >>> teleopctl.activate()
        >>> from std_msgs.msg import String
        >>> with teleopctl.open_node("greeter") as node:
        ...     publisher = node.create_publisher(String, "chatter", 10)
        ...     publisher.publish(String(data="hello"))
        ...     print(node.get_fully_qualified_name(), publisher.topic_name)
        /greeter /chatter
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: QoSProfile | int = qos_profile_rosout_default,
        start_parameter_services: bool = True,
        parameter_overrides: Iterable[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        overrides = tuple(parameter_overrides or ())
        if os.environ.get(LOGGER_SERVICES) and not node_name.startswith("_"):
            enable_logger_service = True
        options = take_next_options()
        if options is not None:
            context = context or options.context
            cli_args = options.command_line(cli_args)
            overrides = (*overrides, *options.parameters)
            use_global_arguments = options.use_global_arguments
            enable_rosout = options.flag("enable_rosout", enable_rosout)
            start_parameter_services = options.flag(
                "start_parameter_services", start_parameter_services
            )
            enable_logger_service = options.flag("enable_logger_service", enable_logger_service)
        super().__init__(node_name, context, cli_args, namespace, use_global_arguments)
        if options is not None:
            options.node = self
            if options.log_level:
                set_logger_level(self._logger.name, options.log_level)
        self._rosout: RosoutPublisher | None = None
        try:
            self._announce()
            if enable_rosout and all(arguments.rosout_logs for arguments in self._arguments):
                from teleopctl.node.node_services import RosoutPublisher

                self._rosout = RosoutPublisher(self, as_qos_profile(rosout_qos_profile))
            self._start_parameters(
                overrides,
                allow_undeclared=allow_undeclared_parameters,
                start_services=start_parameter_services,
            )
            self._start_node_services(
                declare_overrides=automatically_declare_parameters_from_overrides,
                type_descriptions=start_parameter_services,
                logger_service=enable_logger_service,
            )
        except BaseException:
            # A node whose constructor failed must not stay in the graph. Not self.destroy_node():
            # a subclass has not created the objects that its own method destroys.
            Node.destroy_node(self)
            raise

    def _start_node_services(
        self, *, declare_overrides: bool, type_descriptions: bool, logger_service: bool
    ) -> None:
        from teleopctl.node.node_services import TimeSource

        self._time_source = TimeSource(self)
        if declare_overrides:
            self._declare_overrides()
        if type_descriptions:
            from teleopctl.node.node_services import start_type_description_service

            start_type_description_service(self)
        if logger_service:
            from teleopctl.node.node_services import LoggerService

            LoggerService(self)

    def destroy_node(self) -> None:
        """Destroy the node with all its entities, and remove it from the graph. Idempotent."""
        if self._rosout is not None:
            self._rosout.destroy()
        super().destroy_node()
