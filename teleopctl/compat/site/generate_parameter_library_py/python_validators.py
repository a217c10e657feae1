"""``generate_parameter_library_py.python_validators``. Validators of parameters.

Each returns why a parameter is invalid, or an empty text.
"""

from collections.abc import Collection, Sequence
from typing import Any

from rclpy.parameter import Parameter

__all__ = ["ParameterValidators"]

# Any: a number or a text, as the parameter's.


class ParameterValidators:
    """Validators by the names that the YAML files have."""

    @staticmethod
    def _compared(param: Parameter, valid: bool, words: str, value: Any) -> str:
        told = f"Parameter '{param.name}' with the value {param.value} must be {words} {value}"
        return "" if valid else told

    @staticmethod
    def lt(param: Parameter, value: Any) -> str:
        """Check that a value is less than another."""
        valid = param.value < value
        return ParameterValidators._compared(param, valid, "less than", value)

    @staticmethod
    def gt(param: Parameter, value: Any) -> str:
        """Check that a value is greater than another."""
        valid = param.value > value
        return ParameterValidators._compared(param, valid, "greater than", value)

    @staticmethod
    def lt_eq(param: Parameter, value: Any) -> str:
        """Check that a value is at most another."""
        valid = param.value <= value
        return ParameterValidators._compared(param, valid, "below upper bound of", value)

    @staticmethod
    def gt_eq(param: Parameter, value: Any) -> str:
        """Check that a value is at least another."""
        valid = param.value >= value
        return ParameterValidators._compared(param, valid, "above lower bound of", value)

    lower_bounds = gt_eq
    upper_bounds = lt_eq

    @staticmethod
    def not_empty(param: Parameter) -> str:
        """Check that a text or an array is not empty."""
        return "" if len(param.value) else f"Parameter '{param.name}' cannot be empty"

    @staticmethod
    def one_of(param: Parameter, values: Collection[Any]) -> str:
        """Check that a value is one of several."""
        if param.value in values:
            return ""
        return f"Parameter '{param.name}' with the value '{param.value}' is not in the set {values}"

    @staticmethod
    def bounds(param: Parameter, lower: Any, upper: Any) -> str:
        """Check that a value is within bounds."""
        if lower <= param.value <= upper:
            return ""
        where = f"Value {param.value} in parameter '{param.name}'"
        return f"{where} must be within bounds [{lower}, {upper}]"

    @staticmethod
    def unique(param: Parameter) -> str:
        """Check that no value of an array is there twice."""
        if len(set(param.value)) == len(param.value):
            return ""
        return f"Parameter '{param.name}' must only contain unique values"

    @staticmethod
    def subset_of(param: Parameter, values: Collection[Any]) -> str:
        """Check that all values of an array are among several."""
        for value in param.value:
            if value not in values:
                return f"Entry '{value}' in parameter '{param.name}' is not in the set {values}"
        return ""

    @staticmethod
    def _sized(param: Parameter, valid: bool, words: str, length: int) -> str:
        told = f"Length of parameter '{param.name}' is '{len(param.value)}' but must be"
        return "" if valid else f"{told} {words} {length}"

    @staticmethod
    def fixed_size(param: Parameter, length: int) -> str:
        """Check the length of a text or an array."""
        return ParameterValidators._sized(param, len(param.value) == length, "equal to", length)

    @staticmethod
    def size_gt(param: Parameter, length: int) -> str:
        """Check that a text or an array is longer than a length."""
        return ParameterValidators._sized(param, len(param.value) > length, "greater than", length)

    @staticmethod
    def size_lt(param: Parameter, length: int) -> str:
        """Check that a text or an array is shorter than a length."""
        return ParameterValidators._sized(param, len(param.value) < length, "less than", length)

    @staticmethod
    def _elements(param: Parameter, valid: Sequence[bool], words: str) -> str:
        for value, is_valid in zip(param.value, valid, strict=True):
            if not is_valid:
                return f"Value {value} in parameter '{param.name}' must be {words}"
        return ""

    @staticmethod
    def element_bounds(param: Parameter, lower: Any, upper: Any) -> str:
        """Check that all values of an array are within bounds."""
        valid = [lower <= value <= upper for value in param.value]
        return ParameterValidators._elements(param, valid, f"within bounds [{lower}, {upper}]")

    @staticmethod
    def lower_element_bounds(param: Parameter, lower: Any) -> str:
        """Check that all values of an array are at least a bound."""
        valid = [value >= lower for value in param.value]
        return ParameterValidators._elements(param, valid, f"above lower bound of {lower}")

    @staticmethod
    def upper_element_bounds(param: Parameter, upper: Any) -> str:
        """Check that all values of an array are at most a bound."""
        valid = [value <= upper for value in param.value]
        return ParameterValidators._elements(param, valid, f"below upper bound of {upper}")
