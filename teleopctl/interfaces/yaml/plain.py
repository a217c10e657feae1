"""YAML for what leaves no doubt, without PyYAML: its import takes 13 ms, a fifth of a command.

Most commands read or write one small message: names, numbers, short texts. Whatever is not plainly
one of these is left to PyYAML by returning None; tests hold the two equal.
"""

from __future__ import annotations

import re

from teleopctl.typed import Any

# Texts that YAML 1.1 takes for something else, in any case of letters.
_WORDS = frozenset({"true", "false", "yes", "no", "on", "off", "null"})
_BOOLS = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}

_TEXT = re.compile(r"[A-Za-z_/][A-Za-z0-9_./]*(?: [A-Za-z0-9_./]+)*\Z")

_END = r" *(?=[,}\]]|\Z)"
_TOKEN = re.compile(
    r" *(?:(?P<mark>[{}\[\],])"
    r"|(?P<key>[A-Za-z_][A-Za-z0-9_]*):(?= )"
    rf"|(?P<float>-?(?:0|[1-9][0-9]{{0,15}})\.[0-9]{{1,16}}){_END}"
    rf"|(?P<int>-?(?:0|[1-9][0-9]{{0,17}})){_END}"
    rf"|(?P<text>[A-Za-z_][A-Za-z0-9_]*(?: [A-Za-z0-9_]+)*){_END}"
    rf'|"(?P<double>[ !#-\[\]-~]*)"{_END}'
    rf"|'(?P<single>[ -&(-~]*)'{_END})"
)
_LONGEST = 10_000
_DEEPEST = 20


class _NotPlainError(Exception):
    """PyYAML has to look."""


def read_plain(text: str) -> dict[str, Any] | None:  # Any: values of YAML
    """Read ``{x: 1.0, name: [a, b]}`` or ``x: 1.0``; None for what is not so plain."""
    if len(text) > _LONGEST:
        return None
    tokens: list[tuple[str, str]] = []
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None or match.lastgroup is None:
            return None
        tokens.append((match.lastgroup, match[match.lastgroup]))
        at = match.end()
    tokens.append(("end", ""))
    tokens.reverse()
    try:
        if tokens[-1][0] == "key":
            values = {_key(tokens): _value(tokens, 1)}
        elif tokens[-1] == ("mark", "{"):
            values = _value(tokens, 0)
        else:
            return None
        return values if tokens == [("end", "")] else None
    except _NotPlainError:
        return None


def _key(tokens: list[tuple[str, str]]) -> str:
    kind, text = tokens.pop()
    if kind != "key" or text.lower() in _WORDS:
        raise _NotPlainError
    return text


def _value(tokens: list[tuple[str, str]], depth: int) -> Any:
    kind, text = tokens.pop()
    if kind in ("double", "single"):
        return text
    if kind == "int":
        return int(text)
    if kind == "float":
        return float(text)
    if kind == "text" and text in _BOOLS:
        return _BOOLS[text]
    if kind == "text" and text.lower() not in _WORDS:
        return text
    if kind != "mark" or text not in "{[" or depth > _DEEPEST:
        raise _NotPlainError
    return _mapping(tokens, depth) if text == "{" else _sequence(tokens, depth)


def _mapping(tokens: list[tuple[str, str]], depth: int) -> dict[str, Any]:
    values: dict[str, Any] = {}
    while not values or _goes_on(tokens, "}"):
        if not values and tokens[-1] == ("mark", "}"):
            tokens.pop()
            break
        key = _key(tokens)
        if key in values:
            raise _NotPlainError
        values[key] = _value(tokens, depth + 1)
    return values


def _sequence(tokens: list[tuple[str, str]], depth: int) -> list[Any]:
    values: list[Any] = []
    while not values or _goes_on(tokens, "]"):
        if not values and tokens[-1] == ("mark", "]"):
            tokens.pop()
            break
        values.append(_value(tokens, depth + 1))
    return values


def _goes_on(tokens: list[tuple[str, str]], end: str) -> bool:
    """Take a comma, or the end of a mapping or sequence; whether it was a comma."""
    token = tokens.pop()
    if token not in (("mark", ","), ("mark", end)):
        raise _NotPlainError
    return token[1] == ","


# Any: values of any fields.
def write_plain(values: dict[str, Any], *, flow: bool) -> str | None:
    """Write the fields of a message as YAML in blocks; None where not all of it is plain.

    Args:
        values: Numbers, texts, lists and mappings of these.
        flow: Write lists of numbers and texts on one line.
    """
    try:
        return "".join(_lines(values, "", flow))
    except _NotPlainError:
        return None


def _lines(values: dict[str, Any], indent: str, flow: bool) -> list[str]:
    if not values:
        raise _NotPlainError
    lines = []
    for key, value in values.items():
        name = f"{indent}{_scalar(key)}:"
        if isinstance(value, dict):
            lines += [f"{name}\n", *_lines(value, f"{indent}  ", flow)]
        elif not isinstance(value, list):
            lines.append(f"{name} {_scalar(value)}\n")
        elif not value or (flow and not isinstance(value[0], dict)):
            lines.append(f"{name} [{', '.join(map(_scalar, value))}]\n")
        else:
            lines.append(f"{name}\n")
            for element in value:
                lines += _element(element, indent, flow)
    return lines


def _element(element: Any, indent: str, flow: bool) -> list[str]:
    if not isinstance(element, dict):
        return [f"{indent}- {_scalar(element)}\n"]
    if flow:
        raise _NotPlainError
    inner = f"{indent}  "
    first, *others = _lines(element, inner, flow)
    return [f"{indent}- {first.removeprefix(inner)}", *others]


def _scalar(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        if not value:
            return "''"
        if _TEXT.match(value) and value.lower() not in _WORDS:
            return value
        raise _NotPlainError
    text = repr(value)
    if isinstance(value, float):
        if text[-1] in "fn":  # inf and nan
            raise _NotPlainError
        # Without a dot YAML 1.1 would take it for a text.
        return text if "." in text else text.replace("e", ".0e")
    if not isinstance(value, int):
        raise _NotPlainError
    return text
