"""Base class of controllers that other controllers can command."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, TypeVar

from teleopctl.control.controllers.base import ControllerInterface, ControllerInterfaceParams
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import ReturnType, State

I = TypeVar("I", bound=StateInterface)  # noqa: E741 - an interface


class InvalidExportError(Exception):
    """Raised when a controller exports an invalid interface; the message says why."""


class ChainableControllerInterface(ControllerInterface):
    """Base class of controllers that export reference and state interfaces to other controllers.

    A preceding controller commands the *reference interfaces* like a joint's command interfaces;
    any controller can read the *state interfaces*. Both exist while the controller is configured,
    and can be used while it is active. While another controller has claimed the references, the
    controller is in chained mode and ignores its own topics.

    Attributes:
        reference_interfaces: Exported references, which other controllers command.
        exported_state_interfaces: Exported states, which other controllers read.
    """

    base_class: ClassVar[str] = "controller_interface::ChainableControllerInterface"

    def __init__(self, params: ControllerInterfaceParams) -> None:
        super().__init__(params)
        self.reference_interfaces: list[CommandInterface] = []
        self.exported_state_interfaces: list[StateInterface] = []
        self._in_chained_mode = False

    # -- overridden by controllers -----------------------------------------------------------------

    def on_export_reference_interfaces_list(self) -> Sequence[CommandInterface]:
        """Called on configuring: return new reference interfaces for others; none by default.

        An example is ``CommandInterface(f"{self.name}/joint_1", "position")``.
        """
        return ()

    def on_export_state_interfaces_list(self) -> Sequence[StateInterface]:
        """Called on configuring: return new state interfaces for others; none by default."""
        return ()

    def on_set_chained_mode(self, chained_mode: bool) -> bool:
        """Called before activation and after deactivation: return False to refuse; by default True.

        The controller is never active when this is called.
        """
        del chained_mode
        return True

    def update_reference_from_subscribers(self, time_ns: int, period: float) -> ReturnType | None:
        """Called by `update` outside chained mode: set references from received messages."""

    def update_and_write_commands(self, time_ns: int, period: float) -> ReturnType | None:
        """Called by `update`, after references are set: read states and references, write commands.

        Args:
            time_ns: Time of the control cycle, in nanoseconds.
            period: Seconds since this controller's last update; the nominal period at first.
        """
        raise NotImplementedError

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Run one control step: update references unless in chained mode, then write commands."""
        if not self._in_chained_mode:
            outcome = self.update_reference_from_subscribers(time_ns, period)
            if outcome is not None and outcome is not ReturnType.OK:
                return outcome
        return self.update_and_write_commands(time_ns, period)

    # -- called by the manager ---------------------------------------------------------------------

    @property
    def in_chained_mode(self) -> bool:
        """Whether another controller commands the reference interfaces."""
        return self._in_chained_mode

    def set_chained_mode(self, chained_mode: bool) -> bool:
        """Enter or leave chained mode; return False if the controller is active or refuses."""
        if self.lifecycle_state is State.ACTIVE or not self.on_set_chained_mode(chained_mode):
            return False
        self._in_chained_mode = chained_mode
        return True

    def export_interfaces(self) -> None:
        """Create and check all exported interfaces; raise if a name is invalid or there are none.

        Raises:
            InvalidExportError: A name does not begin with the controller's name or is repeated, or
                no interface is exported.
        """
        self.reference_interfaces = self._checked(
            self.on_export_reference_interfaces_list(), "reference"
        )
        self.exported_state_interfaces = self._checked(
            self.on_export_state_interfaces_list(), "state"
        )
        if not self.reference_interfaces and not self.exported_state_interfaces:
            raise InvalidExportError(
                f"Controller '{self.name}' is chainable, but does not export any state or "
                "reference interfaces. Did you override the on_export_state_interfaces_list() or "
                "on_export_reference_interfaces_list() methods correctly?"
            )

    def _checked(self, interfaces: Sequence[I], kind: str) -> list[I]:
        names: set[str] = set()
        for interface in interfaces:
            if interface.prefix_name.partition("/")[0] != self.name:
                raise InvalidExportError(
                    f"The prefix of the interface '{interface.prefix_name}' should begin with the "
                    f"controller's name '{self.name}'. This is mandatory for {kind} interfaces."
                )
            if interface.name in names:
                raise InvalidExportError(
                    f"Controller '{self.name}' exports the {kind} interface '{interface.name}' "
                    "twice."
                )
            names.add(interface.name)
        return list(interfaces)

    def forget_exported_interfaces(self) -> None:
        """Clear the exported interfaces and leave chained mode; called on cleanup."""
        self.reference_interfaces = []
        self.exported_state_interfaces = []
        self._in_chained_mode = False

    def make_exported_interfaces_available(self, available: bool) -> None:
        """Set whether exported interfaces can be used; values of unavailable ones become NaN."""
        for interface in (*self.reference_interfaces, *self.exported_state_interfaces):
            interface.available = available
            if not available:
                interface.value = math.nan
