"""Text field of a panel, and below it the list of what it finds, to be clicked."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.base import Page

MOST_FOUND = 40
"""Largest number of choices in the list; more words find fewer."""

_WORDS = re.compile(r"[\s/.\[\]]+")
_BOX = (
    '<div style="margin:0 12px 6px;font-size:12px;line-height:1.35;max-height:260px;'
    'overflow-y:auto;border:1px solid #8a94a040;border-radius:4px">{rows}</div>'
)
_ROW = (
    '<div {mark}><div style="padding:3px 8px;overflow-wrap:anywhere;'
    'border-top:1px solid #8a94a030"><b>{title}</b><br>'
    '<span style="opacity:.6">{detail}</span></div></div>'
)
_NOTE = '<div style="padding:3px 8px;opacity:.6">{text}</div>'
_EXAMPLE = '<div style="padding:0 12px 6px;font-size:12px;opacity:.6">{text}</div>'


class SearchChoice(NamedTuple):
    """Choice that can be searched for.

    Attributes:
        title: What is chosen, such as a field of a message.
        detail: Where it belongs, such as the topic.
        is_rare: Whether it is found only by a word of its title, such as the stamp of a header.
    """

    title: str
    detail: str
    is_rare: bool = False


def found_choices(text: str, choices: Mapping[str, SearchChoice]) -> list[str]:
    """Return the keys of the choices that have all words of a text, the best ones first.

    Words may stand in any order; space, ``/``, ``.``, ``[`` and ``]`` separate them. Choices whose
    detail consists of words of the text come first, and then those with such a part.

    Args:
        text: The text; an empty one finds nothing.
        choices: The choices by key, in the order that equally good ones keep.
    """
    words = [word for word in _WORDS.split(text.lower()) if word]
    if not words:
        return []
    found: list[tuple[int, str]] = []
    for key, choice in choices.items():
        title, detail = choice.title.lower(), choice.detail.lower()
        if not all(word in title or word in detail for word in words):
            continue
        if choice.is_rare and all(word in detail for word in words):
            continue
        parts = [part for part in _WORDS.split(detail) if part]
        named = sum(part in words for part in parts)
        found.append((0 if named == len(parts) else 1 if named else 2, key))
    return [key for _, key in sorted(found, key=lambda one: one[0])]


class SearchList:
    """Text field, and the list of what it finds; Enter takes the first choice of the list.

    Args:
        page: The page of a panel of one browser.
        panel: Name of the panel in the registry, whose `Panel.clicked` passes a click to `clicked`.
        label: Label of the field.
        example: What may be typed, shown while the field is empty.
        kind: What is searched for, such as "field".
        choose: Function called with the key of a choice.
    """

    def __init__(
        self,
        page: Page,
        panel: str,
        label: str,
        example: str,
        kind: str,
        choose: Callable[[str], object],
    ) -> None:
        self._panel, self._kind, self._choose = panel, kind, choose
        self._choices: Mapping[str, SearchChoice] = {}
        self._example = _EXAMPLE.format(text=escaped_html(example))
        with page.gui.add_form(None) as form:
            self.text: Any = page.gui.add_text(label, "")
        form.on_submit(page.on_node_thread(lambda _event: self._take_first()))
        self.text.on_update(page.on_node_thread(lambda _event: self._show()))
        self.list: Any = page.gui.add_html(self._example)

    def offer(self, choices: Mapping[str, SearchChoice]) -> None:
        """Replace what can be chosen.

        Args:
            choices: The choices by key, in the order in which equally good ones are listed.
        """
        self._choices = choices
        self._show()

    def clicked(self, key: str) -> None:
        """Take a clicked choice, and empty the field.

        Args:
            key: Key of the choice, as the click's mark has it.
        """
        if key in self._choices:
            self.text.value = ""
            self._show()
            self._choose(key)

    def _take_first(self) -> None:
        found = found_choices(self.text.value, self._choices)
        if found:
            self.clicked(found[0])

    def _show(self) -> None:
        text = self.text.value.strip()
        found = found_choices(text, self._choices)
        rows = [
            _ROW.format(
                mark=click_mark(self._panel, f"choose {key}"),
                title=escaped_html(self._choices[key].title),
                detail=escaped_html(self._choices[key].detail),
            )
            for key in found[:MOST_FOUND]
        ]
        if len(found) > MOST_FOUND:
            rows.append(_NOTE.format(text=f"{len(found) - MOST_FOUND} more: type another word"))
        if text and not found:
            rows.append(_NOTE.format(text=f"No {self._kind} contains {escaped_html(text)}"))
        content = _BOX.format(rows="".join(rows)) if text else self._example
        if content != self.list.content:
            self.list.content = content
