"""Options for nodes that other code constructs, as a component container sets them."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.node.context import Context
    from teleopctl.node.node_parameters import NodeParameters
    from teleopctl.node.values.parameter import Parameter


class NodeOptions:
    """Options for the next node that a thread constructs, added to the constructor's arguments.

    The constructor of a component's class often has no arguments, and sets the node's name itself.

    Args:
        arguments: Command line with ``--ros-args`` groups, placed before the node's own.
        parameters: Parameter overrides, which replace those in the node's own code.
        context: Context of the node, unless its code passes another one.
        log_level: Level of the node's logger, or 0 for that of the process.
        use_global_arguments: Whether the command-line arguments of ``init()`` apply.
        flags: Values that replace ``enable_rosout``, ``start_parameter_services`` and
            ``enable_logger_service`` of the node's own code.

    Attributes:
        node: Node that was constructed with the options, also if its constructor raised; None
            before.
    """

    def __init__(
        self,
        arguments: Sequence[str] = (),
        parameters: Sequence[Parameter] = (),
        *,
        context: Context | None = None,
        log_level: int = 0,
        use_global_arguments: bool = False,
        flags: Mapping[str, bool] | None = None,
    ) -> None:
        self.arguments = arguments
        self.parameters = parameters
        self.context = context
        self.log_level = log_level
        self.use_global_arguments = use_global_arguments
        self.flags = flags or {}
        self.node: NodeParameters | None = None

    @contextmanager
    def applied_to_next_node(self) -> Iterator[None]:
        """Return a context manager that applies the options to the thread's next new node."""
        outer = take_next_options()
        _next.options = self
        try:
            yield
        finally:
            _next.options = outer

    def command_line(self, node_arguments: Sequence[str] | None) -> list[str]:
        """Return the options' arguments, then ``--`` and the node's own command line, if any."""
        return [*self.arguments, *(["--", *node_arguments] if node_arguments else ())]

    def flag(self, name: str, constructor_value: bool) -> bool:
        """Return a flag's value in the options, or else that given to the node's constructor."""
        return self.flags.get(name, constructor_value)


class _NextOptions(threading.local):
    options: NodeOptions | None = None


_next = _NextOptions()


def take_next_options() -> NodeOptions | None:
    """Return and clear the options for this thread's next node; None if there are none."""
    options, _next.options = _next.options, None
    return options
