r"""Escaping of received texts for terminals, logs and tables.

Names, messages and errors received from other programs may contain any character. A control
character could move the cursor, change the window's title, ring the bell, or begin a line that
seems to be written by another program. So control characters are escaped as Python does, such as
``\x1b``.
"""

from __future__ import annotations

_ESCAPES = {code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0))} | {
    # Line separators, and characters that change the direction of the following text.
    code: f"\\u{code:04x}"
    for code in (0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A))
}
_IN_LINES = _ESCAPES | {ord("\n"): "\\n", ord("\r"): "\\r"}
del _IN_LINES[ord("\t")]
_IN_TEXTS = {code: escape for code, escape in _IN_LINES.items() if code != ord("\n")}
_IN_JSON = {code: f"\\u{code:04x}" for code in _ESCAPES if code >= 0x7F}

# In characters: about two lines of a terminal.
_LONGEST_QUOTE = 160


def printable_line(text: str) -> str:
    """Return a text as one line, with control characters escaped."""
    return text if text.isprintable() else text.translate(_IN_LINES)


def printable_text(text: str) -> str:
    """Return a text with control characters escaped; line breaks stay."""
    if text.replace("\n", "").isprintable():
        return text
    if "\r" not in text:
        return text.translate(_IN_TEXTS)
    return "\r\n".join(part.translate(_IN_TEXTS) for part in text.split("\r\n"))


def printable_log(text: str) -> str:
    """Return a log message with control characters escaped; colours stay."""
    if "\x1b[" not in text:
        return printable_text(text)
    import re

    parts = re.split(r"(\x1b\[[0-9;]*m)", text)
    shown = "".join(part if index % 2 else printable_text(part) for index, part in enumerate(parts))
    return f"{shown}\x1b[0m" if len(parts) > 1 else shown


def printable_json(document: str) -> str:
    """Return a JSON text with DEL, C1 and text-direction characters as Unicode escapes."""
    return document.translate(_IN_JSON)


def shortened(text: str) -> str:
    """Return a text to quote in a message: cut to 160 characters, with an ellipsis if longer."""
    return text if len(text) <= _LONGEST_QUOTE else f"{text[:_LONGEST_QUOTE]}…"
