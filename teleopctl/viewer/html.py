"""Escaped HTML and Markdown for texts from the network, and the page's short notes.

Names and messages of other nodes may contain any text. The page inserts HTML as it is, and its
Markdown allows HTML, so all texts of other nodes are escaped by these functions first.
"""

from __future__ import annotations

import html
from collections.abc import Mapping

from teleopctl.base.printable import printable_line, printable_text

_LONGEST = 400


def escaped_html(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one line of escaped HTML, cut to ``longest`` characters.

    Args:
        text: Any text.
        longest: Largest number of characters.
    """
    return html.escape(printable_line(_cut(text, longest)))


def escaped_html_lines(text: str, longest: int = _LONGEST) -> str:
    """Return a text of several lines as escaped HTML, cut to ``longest`` characters."""
    return html.escape(printable_text(_cut(text, longest)))


def escaped_markdown(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one line of escaped Markdown, cut to ``longest`` characters."""
    line = printable_line(_cut(text, longest))
    return "".join(sign if sign.isalnum() or sign == " " else f"&#{ord(sign)};" for sign in line)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[:longest]}…"


def age_text(age_s: float) -> str:
    """Return an age in whole seconds or minutes as text: "now", "5 s ago", "2 min ago"."""
    if age_s < 1.0:
        return "now"
    return f"{age_s:.0f} s ago" if age_s < 60.0 else f"{age_s / 60.0:.0f} min ago"


def note_html(content: str, line_height: float = 1.4) -> str:
    """Return the HTML of a paragraph in a panel, around content that is HTML.

    Args:
        content: HTML of the paragraph, in which texts of other nodes are escaped.
        line_height: Height of a line, in font sizes.
    """
    style = f"padding:0 .75em .5em;font-size:14px;line-height:{line_height:g}"
    return f'<div style="{style}">{content}</div>'


def links_html(links: Mapping[str, str]) -> str:
    """Return the HTML of links to other pages of the server, side by side.

    Args:
        links: Titles by path. The cookie of the page's token goes with them.
    """
    style = "flex:1;text-align:center;padding:6px;border:1px solid #8a94a080;border-radius:4px;"
    style += "color:inherit;text-decoration:none;font-size:14px"
    found = "".join(
        f'<a href="{html.escape(path)}" style="{style}">{html.escape(title)}</a>'
        for path, title in links.items()
    )
    return f'<div style="display:flex;gap:6px;padding:0 .75em .5em">{found}</div>'
