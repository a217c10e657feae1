"""Texts of others in HTML and Markdown: shown as they are, and never obeyed.

Names and messages come over the wire and may hold anything. The page puts HTML into the document
as it is, and its Markdown lets HTML through, so every text that is not ours passes here first.
"""

from __future__ import annotations

import html

from teleopctl.base.printable import printable_line, printable_text

_LONGEST = 400


def escaped(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one line of escaped HTML.

    Args:
        text: Anything.
        longest: How many characters are shown.
    """
    return html.escape(printable_line(_cut(text, longest)))


def escaped_lines(text: str, longest: int = _LONGEST) -> str:
    """Return a text of several lines as escaped HTML, for ``white-space: pre``."""
    return html.escape(printable_text(_cut(text, longest)))


def escaped_markdown(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one line of escaped Markdown."""
    line = printable_line(_cut(text, longest))
    return "".join(sign if sign.isalnum() or sign == " " else f"&#{ord(sign)};" for sign in line)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[:longest]}…"


def ago(age_s: float) -> str:
    """Return an age in words, coarsely, so that the text seldom changes."""
    if age_s < 1.0:
        return "now"
    return f"{age_s:.0f} s ago" if age_s < 60.0 else f"{age_s / 60.0:.0f} min ago"
