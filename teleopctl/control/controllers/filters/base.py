"""Base class of filters, and chains of filters from a controller's parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast

from teleopctl import plugins
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface

# Types of filtered values, by the names that the filters' plug-ins have in ROS 2.
DOUBLE = "double"
WRENCH = "geometry_msgs::msg::WrenchStamped"

T = TypeVar("T")


class InvalidFilterError(TeleopctlError):
    """Raised when a parameter of a filter is missing or invalid; the message says why."""


@dataclass(frozen=True)
class FilterParams:
    """Constructor argument of filters.

    Attributes:
        controller: Controller whose values are filtered.
        name: Name of the filter.
        prefix: Prefix of the filter's parameters.
        frame_id: Frame of filtered wrenches, else an empty string.
    """

    controller: ControllerInterface
    name: str
    prefix: str
    frame_id: str = ""


class FilterBase(Generic[T]):
    """Base class of filters of one type of value.

    Args:
        params: Controller, name and parameters' prefix.

    Attributes:
        data_type: Type of the values: ``double``, a float here; or
            ``geometry_msgs::msg::WrenchStamped``, a list of three forces and three torques here.
    """

    data_type: ClassVar[str]

    def __init__(self, params: FilterParams) -> None:
        self.params = params

    # -- overridden by filters ---------------------------------------------------------------------

    def configure(self) -> None:
        """Called on configuring: read the parameters, and create what the filter needs.

        Raises:
            InvalidFilterError: A parameter is missing or invalid.
        """

    def reconfigure(self) -> None:
        """Called when parameters change, outside the control cycle: read those that may change.

        Raises:
            InvalidFilterError: A parameter is invalid; the filter keeps the earlier ones.
        """

    def reset(self) -> None:
        """Called on activation and after a simulation reset: discard earlier values."""

    def close(self) -> None:
        """Called on cleanup: release what ``configure`` created."""

    def update(self, data_in: T) -> T | None:
        """Called in the control cycle: return the filtered value; None if there is none."""
        raise NotImplementedError

    # -- called by filters -------------------------------------------------------------------------

    def number(self, name: str, default: float = math.nan) -> float:
        """Return a parameter of the filter; raise if it is neither given nor has a default."""
        value = self.params.controller.auto_declare(f"{self.params.prefix}.{name}", default)
        if math.isnan(default) and math.isnan(value):
            raise self.invalid(name, "has no value")
        return value

    def optional_number(self, name: str) -> float:
        """Return a parameter of the filter; NaN if it is not given."""
        return self.params.controller.auto_declare(f"{self.params.prefix}.{name}", math.nan)

    def whole_number(self, name: str, lowest: int) -> int:
        """Return an integer parameter of the filter; raise if it is too small or not given."""
        value = self.params.controller.auto_declare(f"{self.params.prefix}.{name}", lowest - 1)
        if value < lowest:
            raise self.invalid(name, f"must be at least {lowest}")
        return value

    def numbers(self, name: str, default: Sequence[float] = ()) -> list[float]:
        """Return a parameter with several numbers; the default if it is not given."""
        parameter = f"{self.params.prefix}.{name}"
        return [float(x) for x in self.params.controller.auto_declare(parameter, list(default))]

    def text(self, name: str) -> str:
        """Return a text parameter of the filter; raise if it is empty or not given."""
        value = self.params.controller.auto_declare(f"{self.params.prefix}.{name}", "")
        if not value:
            raise self.invalid(name, "cannot be empty")
        return value

    def invalid(self, name: str, problem: str) -> InvalidFilterError:
        """Return an error that names a parameter of the filter and its problem."""
        return InvalidFilterError(f"Parameter '{self.params.prefix}.{name}' {problem}")


class FilterChain(Generic[T]):
    """Filters that a value goes through one after the other, from a controller's parameters.

    The parameters are ``<prefix>.filter1.name``, ``.type`` and ``.params`` with those of the
    filter, then ``filter2`` and so on. A chain without filters returns values unchanged.

    Args:
        controller: Controller with the parameters.
        data_type: Type of the values: `DOUBLE` or `WRENCH`.
        prefix: Prefix of the parameters.
        frame_id: Frame of filtered wrenches.
    """

    def __init__(
        self, controller: ControllerInterface, data_type: str, prefix: str, frame_id: str = ""
    ) -> None:
        self._controller = controller
        self._data_type = data_type
        self._prefix = prefix
        self._frame_id = frame_id
        self._filters: list[FilterBase[T]] = []

    def __len__(self) -> int:
        return len(self._filters)

    def configure(self) -> bool:
        """Create the filters; return False, after a line in the log, if one is invalid."""
        try:
            for name, type_name, prefix in self._found():
                self._filters.append(self._created(name, type_name, prefix))
        except TeleopctlError as error:
            self._controller.logger.fatal(str(error))
            self.close()
            return False
        return True

    def _found(self) -> list[tuple[str, str, str]]:
        """Return name, type and parameters' prefix of each filter; raise if one is incomplete."""
        found: list[tuple[str, str, str]] = []
        while True:
            one = f"{self._prefix}.filter{len(found) + 1}"
            name, kind = (self._controller.auto_declare(f"{one}.{key}", "") for key in _KEYS)
            if not name and not kind:
                return found
            if not name or not kind:
                raise InvalidFilterError(f"{one}.name and {one}.type are required")
            if any(name == other for other, _, _ in found):
                raise InvalidFilterError(f"A filter with the name {name} already exists")
            if kind.count("/") != 1:
                raise InvalidFilterError(f"{kind} must be of form <package_name>/<filter_name>")
            found.append((name, kind, f"{one}.params"))

    def _created(self, name: str, type_name: str, prefix: str) -> FilterBase[T]:
        params = FilterParams(self._controller, name, prefix, self._frame_id)
        if plugins.find(plugins.FILTERS, type_name) is None:
            raise InvalidFilterError(self._unknown(type_name))
        kind = cast("type[FilterBase[Any]]", plugins.load(plugins.FILTERS, type_name))
        if kind.data_type != self._data_type:
            raise InvalidFilterError(self._unknown(type_name))
        created: FilterBase[T] = kind(params)
        try:
            created.configure()
        except TeleopctlError as error:
            created.close()
            raise InvalidFilterError(
                f"Could not configure {name} of type {type_name}: {error}"
            ) from None
        return created

    def _unknown(self, type_name: str) -> str:
        known = (
            name
            for name in plugins.FILTERS.builtin
            if cast("type[FilterBase[Any]]", plugins.load(plugins.FILTERS, name)).data_type
            == self._data_type
        )
        return (
            f"Could not load library for {type_name}: According to the loaded plugin descriptions "
            f"the class {type_name} with base class type filters::FilterBase<{self._data_type}> "
            f"does not exist. Declared types are {' '.join(sorted(known))}"
        )

    def parameters_changed(self) -> None:
        """Read the parameters of all filters again; an invalid one is logged and ignored."""
        for one in self._filters:
            try:
                one.reconfigure()
            except TeleopctlError as error:
                self._controller.logger.error(f"{error}: the filter keeps the earlier value")

    def reset(self) -> None:
        """Reset all filters."""
        for one in self._filters:
            one.reset()

    def close(self) -> None:
        """Release the filters."""
        for one in self._filters:
            one.close()
        self._filters.clear()

    def update(self, value: T) -> T | None:
        """Return a value after all filters; None if a filter has no result."""
        filtered: T | None = value
        for one in self._filters:
            if filtered is None:
                break
            filtered = one.update(filtered)
        return filtered


_KEYS = ("name", "type")
