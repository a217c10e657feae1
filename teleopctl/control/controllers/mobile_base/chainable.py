"""Bases that another controller may command: a planner's, or one that keeps a heading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.mobile_base.base import MobileBaseController
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import VELOCITY, CommandInterface


class ChainableBase(MobileBaseController, ChainableControllerInterface):
    """A base whose velocity is a reference: ``NAME/linear/velocity``, ``NAME/angular/velocity``.

    In chained mode the references are the velocity at each update, however old they are; while one
    of them is not a number the base stands still.
    """

    references: ClassVar[Sequence[str]] = ("linear", "angular")

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return the reference interfaces of the velocity's components."""
        return [CommandInterface(f"{self.name}/{part}", VELOCITY) for part in self.references]

    def wanted_velocity(self, time_ns: int) -> BaseVelocity:
        """Return the references in chained mode, else the velocity of the topic."""
        if not self.in_chained_mode:
            return super().wanted_velocity(time_ns)
        values = [reference.value for reference in self.reference_interfaces]
        if not all(map(math.isfinite, values)):
            return BaseVelocity()
        x, *sideways, angular = values
        return BaseVelocity(x, sideways[0] if sideways else 0.0, angular)
