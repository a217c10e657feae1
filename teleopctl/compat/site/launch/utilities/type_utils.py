"""``launch.utilities.type_utils``: typed values, and substitutions that evaluate to them.

Such a value is a scalar, a list of scalars of one type, a substitution, or a list in which
substitutions stand for scalars. Normalized, a substitution is a list of substitutions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING, Any, List, TypeAlias, get_args, get_origin  # noqa: UP035 -- its identity matters

from ..substitution import Substitution
from .ensure_argument_type_impl import ensure_argument_type
from .normalize_to_list_of_substitutions_impl import normalize_to_list_of_substitutions
from .perform_substitutions_impl import perform_substitutions

if TYPE_CHECKING:
    from ..launch_context import LaunchContext

ScalarTypesTuple = (int, float, bool, str)
ListTypesTuple = (List[int], List[float], List[bool], List[str])  # noqa: UP006
AllowedTypesTuple = ScalarTypesTuple + ListTypesTuple

# Any in what follows: a value's type is what these functions find out, and a type may be
# `typing.List[int]`, which is no class.
ScalarTypesType: TypeAlias = type[int] | type[float] | type[bool] | type[str]
AllowedTypesType: TypeAlias = Any
ScalarValueType: TypeAlias = int | float | bool | str
AllowedValueType: TypeAlias = ScalarValueType | Sequence[ScalarValueType]
SomeValueType: TypeAlias = Any
NormalizedValueType: TypeAlias = Any
StrSomeValueType: TypeAlias = Any


def is_typing_list(data_type: Any) -> bool:
    """Return whether a type is `typing.List`, with or without an item type."""
    return data_type is List or get_origin(data_type) is list  # noqa: UP006


def is_valid_scalar_type(data_type: Any) -> bool:
    """Return whether a type is a scalar type."""
    return data_type in ScalarTypesTuple


def extract_type(data_type: AllowedTypesType) -> tuple[ScalarTypesType, bool]:
    """Return the type of a scalar, or of a list's items, and whether it is a list.

    Raises:
        ValueError: The type is neither.
    """
    arguments = get_args(data_type)
    is_list = is_typing_list(data_type) and bool(arguments)
    scalar = arguments[0] if is_list else data_type
    if not is_valid_scalar_type(scalar):
        raise ValueError(f"Unrecognized data type: {data_type}")
    return scalar, is_list


def is_instance_of_valid_type(value: Any, *, can_be_str: bool = False) -> bool:
    """Return whether a value is a scalar or a list of scalars of one type.

    Args:
        value: The value.
        can_be_str: Whether texts may stand among the items.
    """
    if not isinstance(value, list):
        return isinstance(value, ScalarTypesTuple)
    kind = next((type(item) for item in value if type(item) is not str), str)
    if kind not in ScalarTypesTuple:
        return False
    return all(isinstance(item, (kind, str) if can_be_str else kind) for item in value)


def is_instance_of(
    value: Any, data_type: AllowedTypesType | None = None, *, can_be_str: bool = False
) -> bool:
    """Return whether a value is of a type; without one, of any permitted type.

    Raises:
        ValueError: The type is none that is allowed.
    """
    if data_type is None:
        return is_instance_of_valid_type(value, can_be_str=can_be_str)
    scalar, is_list = extract_type(data_type)
    kinds = (scalar, str) if can_be_str else scalar
    if not is_list:
        return isinstance(value, kinds)
    return isinstance(value, list) and all(isinstance(item, kinds) for item in value)


def coerce_to_type(
    value: str, data_type: AllowedTypesType | None = None, *, can_be_str: bool = False
) -> StrSomeValueType:
    """Return a text converted to a type; without one, to the type that YAML gives it.

    Args:
        value: The text.
        data_type: The type.
        can_be_str: Whether what is no number, and items that are none, may stay texts.

    Raises:
        ValueError: The text is not of the type, or the type is not permitted.
    """
    ensure_argument_type(value, str, "value", "coerce_to_type")
    if data_type is None:
        read = _as_yaml(value, f"Failed to convert '{value}' using yaml rules")
        if not is_instance_of_valid_type(read, can_be_str=can_be_str):
            raise ValueError(f"Failed to convert '{value}' using yaml rules")
        return read
    scalar, is_list = extract_type(data_type)
    if scalar is str and not is_list:
        return value
    if scalar in (int, float) and not is_list:
        try:
            return scalar(value)
        except ValueError:
            if can_be_str:
                return value
            raise
    if scalar is bool and not is_list:
        value = {"1": "true", "0": "false"}.get(value, value)
    wrong = f"Cannot convert value '{value}' to {'a list of ' if is_list else ''}'{scalar}'"
    read = _as_yaml(value, wrong)
    if not is_instance_of(read, data_type, can_be_str=can_be_str):
        raise ValueError(f"{wrong}, got {read}")
    return read


def _as_yaml(text: str, wrong: str) -> Any:
    if not text:
        return ""
    import yaml

    from teleopctl.base import ros_yaml

    try:
        return ros_yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(wrong) from error


def coerce_list(
    value: list[str], data_type: AllowedTypesType | None = None, *, can_be_str: bool = False
) -> StrSomeValueType:
    """Return texts converted to scalars of one type.

    Raises:
        ValueError: They are none.
    """
    ensure_argument_type(value, list, "value", "coerce_list")
    read = [coerce_to_type(item, data_type, can_be_str=can_be_str) for item in value]
    if not is_instance_of_valid_type(read, can_be_str=can_be_str):
        raise ValueError(f"cannot convert value to {data_type}. Got value=`{value}`")
    return read


def get_typed_value(
    value: str | list[str], data_type: AllowedTypesType | None, *, can_be_str: bool = False
) -> StrSomeValueType:
    """Return a text or texts converted to a type.

    Raises:
        ValueError: They are no such value.
        TypeError: There are several, and the type is none of a list.
    """
    if not isinstance(value, list):
        return coerce_to_type(value, data_type, can_be_str=can_be_str)
    if data_type is not None:
        data_type, is_list = extract_type(data_type)
        if not is_list:
            raise TypeError(
                f"Cannot convert input '{value}' of type '{type(value)}' to '{data_type}'"
            )
    return coerce_list(value, data_type, can_be_str=can_be_str)


def is_substitution(x: Any) -> bool:
    """Return whether an object is a substitution, or a sequence of texts and substitutions."""
    if isinstance(x, Substitution):
        return True
    return (
        isinstance(x, Collection)
        and all(isinstance(item, Substitution | str) for item in x)
        and any(isinstance(item, Substitution) for item in x)
    )


def is_normalized_substitution(x: Any) -> bool:
    """Return whether an object is a list of substitutions."""
    return isinstance(x, list) and bool(x) and all(isinstance(item, Substitution) for item in x)


def normalize_typed_substitution(
    value: SomeValueType, data_type: AllowedTypesType | None
) -> NormalizedValueType:
    """Return a value with the substitutions in it as lists of substitutions.

    Args:
        value: The value. Texts and substitutions in a row are one substitution; for a list of
            texts, the substitutions stand in lists of their own.
        data_type: Type of the result, or None for any.

    Raises:
        TypeError: The value cannot have that type.
        ValueError: The type is none that is allowed.
    """
    if isinstance(value, ScalarTypesTuple):
        if not is_instance_of(value, data_type):
            raise TypeError(f"value='{value}' is not an instance of {data_type}")
        return value
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if not isinstance(value, Iterable):
        raise TypeError(
            "value should be either a scalar, a substitutions, or a mixed list of scalars and "
            f"substitutions. Got `value={value}` of type `{type(value)}`. "
        )
    return _normalized_list(list(value), data_type)


def _normalized_list(value: list[Any], data_type: AllowedTypesType | None) -> list[Any]:
    wanted: ScalarTypesType | None = None
    kinds: set[type] = set()
    for item in value:
        if isinstance(item, ScalarTypesTuple):
            kinds.add(type(item))
        elif not is_substitution(item):
            raise TypeError(
                "value is a list, and one of the items is not a scalar, a Substitution "
                f"or a list of substitutions. Got value='{value}'"
            )
    if data_type is not None:
        wanted, is_list = extract_type(data_type)
        if not is_list:
            raise TypeError(
                "The provided value resolves to a list, though the required type is a scalar. "
                f"Got value='{value}', data_type='{wanted}'."
            )
    found: type | None = float if kinds == {int, float} else next(iter(kinds), None)
    if len(kinds) > 1 and found is not float:
        raise TypeError(f"Input value is not an acceptable 'SomeValueType'.Got value='{value}'")
    if found is int and wanted is float:
        found = float
    if None not in (found, wanted) and found is not wanted:
        raise TypeError(f"Got a list of '{found}', expected a list of '{wanted}'. value='{value}'")
    return [
        normalize_to_list_of_substitutions(item)
        if is_substitution(item)
        else float(item)
        if found is float
        else item
        for item in value
    ]


def perform_typed_substitution(
    context: LaunchContext, value: NormalizedValueType, data_type: AllowedTypesType | None
) -> StrSomeValueType:
    """Return the value of a normalized value, with its substitutions performed.

    Raises:
        TypeError: The value cannot have that type.
        ValueError: The evaluated text is not of the type, or the type is not permitted.
    """
    if isinstance(value, ScalarTypesTuple):
        if not is_instance_of(value, data_type):
            raise TypeError(f"value=`{value}` is a scalar and not an instance of `{data_type}`")
        return value
    if is_normalized_substitution(value):
        return coerce_to_type(perform_substitutions(context, value), data_type)
    if not isinstance(value, list):
        raise TypeError(
            f"Input value is not an acceptable 'NormalizedValueType'.Got value='{value}'"
        )
    scalar: ScalarTypesType | None = None
    if data_type is not None:
        scalar, is_list = extract_type(data_type)
        if not is_list:
            raise ValueError(
                "The input value is a list, cannot convert it to a scalar. "
                f"Got value='{value}', expected type {scalar}."
            )
    read = [
        coerce_to_type(perform_substitutions(context, item), scalar)
        if is_normalized_substitution(item)
        else item
        for item in value
    ]
    if not is_instance_of(read, data_type):
        raise ValueError(
            "The output list is not uniform"
            if scalar is None
            else "The output list does not match the expected type "
            f"Got value='{value}', expected type {scalar}."
        )
    return read
