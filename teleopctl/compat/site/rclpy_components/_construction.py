"""Construction of a component's node from a ``load_node`` request."""

from __future__ import annotations

import importlib
import inspect
import sys
import traceback
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from teleopctl.errors import TeleopctlError
from teleopctl.node import NodeOptions
from teleopctl.packages import Component

if TYPE_CHECKING:
    from composition_interfaces.srv import LoadNode

# object: a component may be anything that has a node.
Constructor = Callable[..., object]

_FLAGS = ("enable_rosout", "start_parameter_services", "enable_logger_service")


class ComponentError(TeleopctlError):
    """A component cannot be loaded."""


def constructor(component: Component) -> Constructor:
    """Import a component's class, or the function that makes it.

    Raises:
        ComponentError: The component cannot be imported.
    """
    for root in map(str, component.import_roots):
        if root not in sys.path:
            sys.path.insert(0, root)
    module, _, name = component.target.partition("[")[0].strip().partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:
        raise ComponentError(f"Failed to load {component.target}: {_told(error)}") from error
    if not callable(found):
        raise ComponentError(f"Failed to load {component.target}: it is no class")
    made: Constructor = found
    return made


def node_options(
    request: LoadNode.Request, extra: Mapping[str, bool], context: Context
) -> NodeOptions:
    """Return the node options of a component.

    Raises:
        TeleopctlError: A remapping rule is malformed.
    """
    rules = list(request.remap_rules)
    if request.node_name:
        rules.append(f"__node:={request.node_name}")
    if request.node_namespace:
        rules.append(f"__ns:={request.node_namespace}")
    return NodeOptions(
        ["--ros-args", *(word for rule in rules for word in ("-r", rule))],
        [Parameter.from_parameter_msg(message) for message in request.parameters],
        context=context,
        log_level=request.log_level,
        use_global_arguments=extra.get("forward_global_arguments", False),
        flags={name: extra[name] for name in _FLAGS if name in extra},
    )


def constructed(
    make: Constructor, request: LoadNode.Request, options: NodeOptions
) -> tuple[object, Node]:
    """Construct a component; destroy its nodes if the constructor fails.

    Returns:
        The component and its node, which mostly are one.

    Raises:
        ComponentError: Its constructor raises, or makes no node.
    """
    try:
        with options.applied_to_next_node():
            component = make(**_arguments(make, request, options))
        if not isinstance(options.node, Node):
            raise TypeError("it has made no node")
    except (Exception, SystemExit) as error:
        if isinstance(options.node, Node):
            options.node.destroy_node()
        raise ComponentError(f"Component constructor threw an exception: {_told(error)}") from error
    return component, options.node


def destroy(component: object, node: Node) -> None:
    """Destroy a component's node, by its own method if it has one."""
    try:
        own = getattr(component, "destroy_node", None)
        if callable(own):
            own()
    except Exception:  # noqa: BLE001 -- third-party code must not stop the container
        traceback.print_exc()
    finally:
        node.destroy_node()


# Any: constructors of components differ.
def _arguments(
    make: Constructor, request: LoadNode.Request, options: NodeOptions
) -> dict[str, Any]:
    """Return the arguments that a constructor requires; all others reach the node as options."""
    try:
        parameters = inspect.signature(make).parameters.values()
    except (TypeError, ValueError):  # one that is compiled
        return {}
    known = {
        "context": options.context,
        "cli_args": None,
        "namespace": request.node_namespace or None,
        "parameter_overrides": None,
        "use_global_arguments": False,
    }
    required = [
        parameter.name
        for parameter in parameters
        if parameter.default is parameter.empty
        and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    ]
    given: dict[str, Any] = {name: known[name] for name in required if name in known}
    # The first of the others is the node's name, whatever it is called.
    for name in [name for name in required if name not in known][:1]:
        given[name] = request.node_name or _name_of(make)
    return given


def _name_of(make: Constructor) -> str:
    return str(getattr(make, "__name__", "component")).lower()


def _told(error: BaseException) -> str:
    if isinstance(error, TeleopctlError):
        return error.message
    # The lines of the component's own, without the call from here.
    inside = error.__traceback__.tb_next if error.__traceback__ is not None else None
    traceback.print_exception(error.with_traceback(inside))
    return str(error) or repr(error)
