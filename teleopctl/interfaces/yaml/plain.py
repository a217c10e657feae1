"""Fast reader and writer of simple YAML, without PyYAML, whose import takes 13 ms.

Most commands read or write one small message: names, numbers, short strings. For all other YAML the
functions return None, and PyYAML is used; tests check that both give equal results.
"""

from __future__ import annotations

from teleopctl.base.typed import Any, Iterator

# Words that YAML 1.1 does not parse as strings, in any case of letters.
_WORDS = frozenset({"true", "false", "yes", "no", "on", "off", "null"})
_BOOLS = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}

_LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_")
_DIGITS = frozenset("0123456789")
_OF_WORDS = _LETTERS | _DIGITS
# Characters of strings that are written without quotes; strings that are read may have fewer.
_OF_TEXTS = _OF_WORDS | frozenset("./")
_PRINTABLE = frozenset(map(chr, range(ord(" "), ord("~") + 1)))
_IN_QUOTES = {'"': _PRINTABLE - frozenset('"\\'), "'": _PRINTABLE - {"'"}}
_MARKS = frozenset("{}[],")
_ENDS = frozenset(",}]")
_BEHIND_WORDS = _ENDS | frozenset(":{[\"'")
_LONGEST = 10_000
_DEEPEST = 20


class _NotPlainError(Exception):
    """The YAML is not simple: PyYAML has to read or write it."""


def read_plain(text: str) -> dict[str, Any] | None:  # Any: values of YAML
    """Return the mapping in simple YAML such as ``{x: 1.0, name: [a, b]}``; None if not simple."""
    if len(text) > _LONGEST:
        return None
    try:
        tokens = [*_tokens(text), ("end", "")]
        tokens.reverse()
        if tokens[-1][0] == "key":
            values = {_key(tokens): _value(tokens, 1)}
        elif tokens[-1] == ("mark", "{"):
            values = _value(tokens, 0)
        else:
            return None
        return values if tokens == [("end", "")] else None
    except _NotPlainError:
        return None


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    """Yield kind and text of each token; without re, whose import takes 2 ms."""
    at = 0
    while at < len(text):
        while text[at : at + 1] == " ":
            at += 1
        letter = text[at : at + 1]
        if letter in _MARKS:
            yield "mark", letter
            at += 1
            continue
        if letter in _IN_QUOTES:
            end = text.find(letter, at + 1)
            content = text[at + 1 : end]
            if end < 0 or not _IN_QUOTES[letter].issuperset(content):
                raise _NotPlainError
            yield "quoted", content
            at = end + 1
        else:
            end = next((i for i in range(at, len(text)) if text[i] in _BEHIND_WORDS), len(text))
            word = text[at:end]
            if text[end : end + 2] == ": " and _OF_WORDS.issuperset(word) and word[:1] in _LETTERS:
                yield "key", word
                at = end + 1
                continue
            word = word.rstrip(" ")
            yield _kind(word), word
            at = end
        while text[at : at + 1] == " ":
            at += 1
        if at < len(text) and text[at] not in _ENDS:
            raise _NotPlainError


def _kind(word: str) -> str:
    """Return the kind of a word without quotes: ``int``, ``float`` or ``text``."""
    whole, dot, fraction = word.removeprefix("-").partition(".")
    if _is_number(whole, 16 if dot else 18) and (whole == "0" or whole[0] != "0"):
        if not dot:
            return "int"
        if _is_number(fraction, 16):
            return "float"
    if _is_text(word, _OF_WORDS):
        return "text"
    raise _NotPlainError


def _is_number(text: str, most_digits: int) -> bool:
    return 0 < len(text) <= most_digits and _DIGITS.issuperset(text)


def _is_text(text: str, allowed: frozenset[str]) -> bool:
    """Return whether a text consists of words of these characters, separated by one blank."""
    return text[:1] in _LETTERS and all(
        word and allowed.issuperset(word) for word in text.split(" ")
    )


def _key(tokens: list[tuple[str, str]]) -> str:
    kind, text = tokens.pop()
    if kind != "key" or text.lower() in _WORDS:
        raise _NotPlainError
    return text


def _value(tokens: list[tuple[str, str]], depth: int) -> Any:
    kind, text = tokens.pop()
    if kind == "quoted":
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
    while not values or _has_next(tokens, "}"):
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
    while not values or _has_next(tokens, "]"):
        if not values and tokens[-1] == ("mark", "]"):
            tokens.pop()
            break
        values.append(_value(tokens, depth + 1))
    return values


def _has_next(tokens: list[tuple[str, str]], end: str) -> bool:
    """Remove a comma or the end of a mapping or sequence; return whether it was a comma."""
    token = tokens.pop()
    if token not in (("mark", ","), ("mark", end)):
        raise _NotPlainError
    return token[1] == ","


# Any: values of any fields.
def write_plain(values: dict[str, Any], *, flow: bool) -> str | None:
    """Return simple message fields as block-style YAML; None if some are not simple.

    Args:
        values: Fields by name: numbers, strings, lists and mappings.
        flow: Whether to write lists of numbers and strings on one line.
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
        first, others = value[:1], value[1:]
        if _is_text(f"{'_' if first == '/' else first}{others}", _OF_TEXTS) and (
            value.lower() not in _WORDS
        ):
            return value
        raise _NotPlainError
    text = repr(value)
    if isinstance(value, float):
        if text[-1] in "fn":  # inf and nan
            raise _NotPlainError
        # YAML 1.1 parses an exponent without a dot, such as 1e-07, as a string.
        return text if "." in text else text.replace("e", ".0e")
    if not isinstance(value, int):
        raise _NotPlainError
    return text
