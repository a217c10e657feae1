"""``rclpy_components.component_manager``: the node that loads components and unloads them."""

from __future__ import annotations

from collections.abc import Iterable
from threading import Thread
from typing import TYPE_CHECKING, Any, NamedTuple

from composition_interfaces.srv import ListNodes, LoadNode, UnloadNode
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from rclpy_components._construction import (
    ComponentError,
    constructed,
    constructor,
    destroy,
    node_options,
)
from teleopctl.base import progress
from teleopctl.errors import TeleopctlError
from teleopctl.node import spin_in_thread
from teleopctl.packages import find_component

if TYPE_CHECKING:
    from collections.abc import Callable

    from rcl_interfaces.msg import Parameter as ParameterMessage


class _Loaded(NamedTuple):
    # object: what a component's class makes need not be a node itself.
    component: object
    node: Node
    executor: Executor
    thread: Thread | None


class ComponentManager(Node):
    """Node with the services ``~/_container/load_node``, ``unload_node`` and ``list_nodes``.

    Args:
        executor: Runs the components' callbacks; None where `set_executor` is to come.
        name: The container's name.
        make_executor: Makes an executor for each component, which spins in a thread of its own;
            None has them all in that of the container (ours).
        kwargs: Further arguments of `Node`.
    """

    # Any: arguments of `Node.`
    def __init__(
        self,
        executor: Executor | None,
        name: str = "py_component_manager",
        *,
        make_executor: Callable[[], Executor] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(name, **kwargs)
        self._shared = executor
        self._make_executor = make_executor
        self._loaded: dict[int, _Loaded] = {}
        self._last_id = 0
        self.create_service(LoadNode, "~/_container/load_node", self.on_load_node)
        self.create_service(UnloadNode, "~/_container/unload_node", self.on_unload_node)
        self.create_service(ListNodes, "~/_container/list_nodes", self.on_list_node)

    def set_executor(self, executor: Executor) -> None:
        """Set the executor that runs the callbacks of components loaded from now on."""
        self._shared = executor

    def on_list_node(
        self, _request: ListNodes.Request, response: ListNodes.Response
    ) -> ListNodes.Response:
        """Return the loaded components."""
        response.unique_ids = list(self._loaded)
        response.full_node_names = [
            loaded.node.get_fully_qualified_name() for loaded in self._loaded.values()
        ]
        return response

    def on_load_node(
        self, request: LoadNode.Request, response: LoadNode.Response
    ) -> LoadNode.Response:
        """Load a component; an error affects neither the container nor other components."""
        try:
            found = find_component(request.package_name, request.plugin_name)
            self.get_logger().info(f"Found class: {found.type_name} ({found.target})")
            make = constructor(found)
            extra = self._extra_arguments(request.extra_arguments)
            options = node_options(request, extra, self.context)
            self.get_logger().info(f"Instantiate class: {found.type_name}")
            component, node = constructed(make, request, options)
        except (ComponentError, TeleopctlError) as error:
            hint = f". {error.hint}" if error.hint else ""
            self.get_logger().error(f"{error.message.rstrip('.')}{hint}")
            response.success = False
            response.error_message = error.message
        else:
            self._last_id += 1
            self._loaded[self._last_id] = self._spun(component, node)
            response.success = True
            response.unique_id = self._last_id
            response.full_node_name = node.get_fully_qualified_name()
        # A component may have reported progress, as if it owned the process.
        progress.report(progress.READY)
        return response

    def on_unload_node(
        self, request: UnloadNode.Request, response: UnloadNode.Response
    ) -> UnloadNode.Response:
        """Unload a component, and destroy its node."""
        loaded = self._loaded.pop(request.unique_id, None)
        response.success = loaded is not None
        if loaded is None:
            response.error_message = f"No node found with unique_id: {request.unique_id}"
            self.get_logger().warning(response.error_message)
        else:
            self._unload(loaded)
        return response

    def destroy_node(self) -> None:
        """Destroy the components, and then the container's own node."""
        loaded, self._loaded = getattr(self, "_loaded", {}), {}
        for each in loaded.values():
            self._unload(each)
        super().destroy_node()

    def _spun(self, component: object, node: Node) -> _Loaded:
        executor, thread = self._shared, None
        if self._make_executor is not None:
            executor = self._make_executor()
        assert executor is not None, "set_executor() has not been called"
        executor.add_node(node)
        if executor is not self._shared:
            # A signal ends the container; handlers are set in its main thread.
            thread = spin_in_thread(executor, node.get_name())
        return _Loaded(component, node, executor, thread)

    def _unload(self, loaded: _Loaded) -> None:
        loaded.executor.remove_node(loaded.node)
        if loaded.thread is not None:
            loaded.executor.shutdown()
            loaded.thread.join()
        destroy(loaded.component, loaded.node)

    def _extra_arguments(self, given: Iterable[ParameterMessage]) -> dict[str, bool]:
        """Read the arguments for the container; those that mean nothing here are accepted."""
        found: dict[str, bool] = {}
        for message in given:
            argument = Parameter.from_parameter_msg(message)
            if argument.name not in _EXTRA_ARGUMENTS:
                self.get_logger().warning(
                    f"Extra component argument '{argument.name}' is not supported"
                )
            elif not isinstance(argument.value, bool):
                raise ComponentError(
                    f"Extra component argument '{argument.name}' must be a boolean"
                )
            else:
                found[argument.name] = argument.value
        return found


_EXTRA_ARGUMENTS = (
    "enable_logger_service",
    "enable_rosout",
    "enable_topic_statistics",
    "forward_global_arguments",
    "start_parameter_event_publisher",
    "start_parameter_services",
    "use_clock_thread",
    "use_intra_process_comms",
)
