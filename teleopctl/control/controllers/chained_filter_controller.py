"""Controller that filters state interfaces for other controllers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.base import InterfaceConfiguration, InterfaceConfigurationType
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.filters.base import DOUBLE, FilterChain
from teleopctl.control.handles import StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

_CHAIN = "filter_chain"


class ChainedFilter(ChainableControllerInterface):
    """Controller that exports filtered values of state interfaces as states.

    Plug-in type ``chained_filter_controller/ChainedFilter``.

    Each of the ``input_interfaces`` goes through the filters of ``filter_chain``, or else of its
    own ``<input interface>.filter_chain``, to the output interface at the same place, with the
    controller's name as prefix. An input that is not finite leaves the output as it is.
    """

    def on_init(self) -> None:
        """Register for parameter changes; the parameters are declared in ``on_configure``."""
        self._chains: list[FilterChain[float]] = []
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the filters of each interface."""
        none: list[str] = []
        self._inputs: list[str] = self.auto_declare("input_interfaces", none, read_only=True)
        self._outputs: list[str] = self.auto_declare("output_interfaces", none, read_only=True)
        for name, value in (("input", self._inputs), ("output", self._outputs)):
            if not value:
                self.logger.error(f"Parameter '{name}_interfaces' cannot be empty")
                return CallbackReturn.FAILURE
        if len(self._inputs) != len(self._outputs):
            self.logger.error(
                "Input and output interfaces have to have the same size. "
                f"({len(self._inputs)} and {len(self._outputs)})"
            )
            return CallbackReturn.FAILURE
        for_all = bool(self.auto_declare(f"{_CHAIN}.filter1.name", ""))
        if for_all and len(self._inputs) > 1:
            self.logger.info("Using global filter setting for all interfaces.")
        self._close()
        for name in self._inputs:
            chain: FilterChain[float] = FilterChain(
                self, DOUBLE, _CHAIN if for_all else f"{name}.{_CHAIN}"
            )
            if not chain.configure():
                self.logger.error(
                    f"Failed to configure filter chain for interfaces  {name}. Check the "
                    "parameters for filters setup."
                )
                return CallbackReturn.FAILURE
            self._chains.append(chain)
        return None

    def on_cleanup(self) -> None:
        """Release the filters."""
        self._close()

    def _close(self) -> None:
        for chain in self._chains:
            chain.close()
        self._chains = []

    # Any: parameters of any type.
    def _parameters_changed(self, parameters: Sequence[Any]) -> None:
        del parameters
        for chain in self._chains:
            chain.parameters_changed()

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces that are filtered."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._inputs)

    def on_export_state_interfaces_list(self) -> list[StateInterface]:
        """Return a new state interface for each output."""
        parts = (name.rpartition("/") for name in self._outputs)
        return [
            StateInterface(f"{self.name}/{prefix}".removesuffix("/"), name)
            for prefix, _, name in parts
        ]

    def on_activate(self) -> None:
        """Set the outputs to NaN, and reset the filters."""
        for state in self.exported_state_interfaces:
            state.value = math.nan
        for chain in self._chains:
            chain.reset()

    def on_restart(self) -> None:
        """Set the outputs to NaN, and reset the filters, after a simulation reset."""
        self.on_activate()

    def update_and_write_commands(self, time_ns: int, period: float) -> ReturnType | None:
        """Filter the present values."""
        del time_ns, period
        for state, chain, output in zip(
            self.state_interfaces, self._chains, self.exported_state_interfaces, strict=True
        ):
            if math.isfinite(state.value):
                filtered = chain.update(state.value)
                if filtered is not None:
                    output.value = filtered
        return None
