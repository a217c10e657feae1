"""Evaluation of node parameters in launch files: values, types, and generated parameter files."""

from __future__ import annotations

from teleopctl.base.printable import shortened
from teleopctl.base.typed import Any, Iterable
from teleopctl.errors import LaunchError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.substitution import evaluated_text
from teleopctl.launch.model import values
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterTree
from teleopctl.launch.model.template import Template

_TRUE = frozenset({"true", "yes", "on"})
_FALSE = frozenset({"false", "no", "off"})
_EXPECTED = {"bool": "true or false", "int": "an integer", "float": "a number"}


def _quoting_dumper() -> Any:
    """Return a YAML dumper that quotes every text, so that no reader takes ``1e3`` for a number."""
    import yaml

    base: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
    dumper: Any = type("QuotingDumper", (base,), {})
    dumper.add_representer(
        str, lambda self, text: self.represent_scalar("tag:yaml.org,2002:str", text, style='"')
    )
    return dumper


def infer_value(text: str) -> object:
    """Return the YAML scalar or list of one type that a text denotes; other texts unchanged.

    ``24`` is an integer, ``1e-3`` a float, ``true`` a boolean, ``[1, 2]`` a list, ``'24'`` a text.
    """
    value = values.typed(text)
    return unify_types(value) if isinstance(value, list) else value


def parameter_value(entry: ParameterEntry, context: LaunchContext) -> object:
    """Evaluate a parameter of a launch file to its typed value.

    Raises:
        TeleopctlError: The value cannot be evaluated, does not have the type that the entry
            demands, or has a type that no parameter can have.
    """
    from teleopctl.node import parameter_value_problem

    value = _tree_value(entry.value, entry.type_name, context)
    reason = parameter_value_problem(value)
    if reason is not None:
        raise LaunchError(f"{shortened(str(value))} cannot be its value: {reason}")
    return value


def _tree_value(tree: ParameterTree, type_name: str | None, context: LaunchContext) -> object:
    if isinstance(tree, list):
        item_type = type_name.removeprefix("list_of_") if type_name else None
        return unify_types([_tree_value(item, item_type, context) for item in tree])
    if isinstance(tree, Template):
        text = evaluated_text(tree, context)
        with context.reading(tree):
            return infer_value(text) if type_name is None else convert(text, type_name)
    if type_name is None:
        return tree
    return convert(str(tree).lower() if isinstance(tree, bool) else str(tree), type_name)


def convert(text: str, type_name: str) -> object:
    """Convert a text to the type that a parameter's ``type:`` names.

    Args:
        text: Text from the launch file.
        type_name: ``bool``, ``int``, ``float``, ``str``, or ``list_of_`` and one of these.

    Raises:
        LaunchError: The text is not of that type.
    """
    if type_name.startswith("list_of_"):
        items = values.typed(text)
        if not isinstance(items, list):
            raise LaunchError(f"expected a list like [a, b], got '{text}'")
        return [convert(str(item), type_name.removeprefix("list_of_")) for item in items]
    if type_name == "str":
        return text
    word = text.strip()
    try:
        if type_name == "int":
            return int(word, 0)
        if type_name == "float":
            return float(word)
    except ValueError:
        pass
    if type_name == "bool" and word.lower() in _TRUE | _FALSE:
        return word.lower() in _TRUE
    raise LaunchError(f"expected {_EXPECTED[type_name]}, got '{text}'")


# Any: a parameter has one of nine types.
def unify_types(items: list[Any]) -> list[Any]:
    """Return list items in one type: integers beside floats become floats; other mixes raise.

    Raises:
        LaunchError: The items have types that cannot be combined.
    """
    kinds = {type(item) for item in items}
    if kinds == {int, float}:
        return [float(item) for item in items]
    if len(kinds) > 1:
        names = ", ".join(sorted(kind.__name__ for kind in kinds))
        raise LaunchError(f"the items of a list parameter have one type, these have {names}")
    return items


def parameter_file(parameters: Iterable[tuple[str, object]]) -> str:
    """Return the YAML of a parameter file for any node; later parameters override earlier."""
    document = {"/**": {"ros__parameters": dict(parameters)}}
    import yaml

    text: str = yaml.dump(
        document, Dumper=_quoting_dumper(), sort_keys=False, allow_unicode=True, width=2**20
    )
    return text
