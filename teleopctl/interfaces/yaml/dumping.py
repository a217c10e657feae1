"""Output of message values as YAML by PyYAML, where the fast writer does not suffice."""

from __future__ import annotations

import yaml

from teleopctl.base.typed import Any

_UNLIMITED = 2**31 - 1
_LONG_ESCAPE = "\\U"
_NEXT_LINE = "\x85"


class _PlainDumper(yaml.SafeDumper):
    """Writes mappings as blocks in every style, as ROS 2 does."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 - signature of PyYAML
        return True


class _FastDumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """`_PlainDumper` on libyaml, which is many times faster."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 - signature of PyYAML
        return True


def _represent_mapping(dumper: yaml.SafeDumper, data: dict[str, Any]) -> yaml.MappingNode:
    represent = dumper.represent_data
    items = [(represent(key), represent(value)) for key, value in data.items()]
    return yaml.MappingNode("tag:yaml.org,2002:map", items)


_PlainDumper.add_representer(dict, _represent_mapping)
_FastDumper.add_representer(dict, _represent_mapping)


# Any: values of any fields.
def dump(values: dict[str, Any], *, flow: bool) -> str:
    """Return message field values as block-style YAML, written by PyYAML.

    Args:
        values: Fields by name: numbers, strings, lists and mappings.
        flow: Whether to write lists on one line.
    """
    text = _dump(values, _FastDumper, flow)
    if _LONG_ESCAPE not in text:
        return text
    # libyaml escapes characters beyond the basic plane, such as emoji; ROS 2 prints them. ROS 2's
    # dumper prints U+0085 as a line break, so that a text with U+0085 stays escaped here.
    plain = _dump(values, _PlainDumper, flow)
    return text if _NEXT_LINE in plain else plain


def _dump(values: object, dumper: type[Any], flow: bool) -> str:
    text: str = yaml.dump(
        values, Dumper=dumper, allow_unicode=True, width=_UNLIMITED, default_flow_style=flow
    )
    return text
