"""Small windows over the screen: yes or no, and a line of text."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.suggester import SuggestFromList
from textual.widgets import Input, Label

_STYLE = """
    align: center middle;
    Vertical {
        width: 90%;
        max-width: 72;
        height: auto;
        padding: 1 2;
        background: $panel;
        border: round $primary;
    }
"""


class Confirm(ModalScreen[bool]):
    """Confirmation of a stop; the result is True for yes.

    Args:
        question: The question.
    """

    DEFAULT_CSS = f"Confirm {{ {_STYLE} }}"
    BINDINGS: ClassVar[list[BindingType]] = [
        ("y,enter", "answer(True)", "Yes"),
        ("n,escape,q", "answer(False)", "No"),
    ]

    def __init__(self, question: str) -> None:
        super().__init__()
        self._question = question

    def compose(self) -> ComposeResult:
        """Add the question and its two keys."""
        with Vertical():
            yield Label(self._question, markup=False)
            yield Label("y  yes      n  no")

    def action_answer(self, answer: bool) -> None:
        """Close with an answer."""
        self.dismiss(answer)


class Ask(ModalScreen[str | None]):
    """Input of a line of text; the result is None if it is left.

    Args:
        question: What stands above the line.
        value: What the line begins with.
        suggestions: What may be meant; the right arrow takes what is shown.
    """

    DEFAULT_CSS = f"Ask {{ {_STYLE} }}"
    BINDINGS: ClassVar[list[BindingType]] = [("escape", "leave", "Leave")]

    def __init__(self, question: str, value: str = "", suggestions: tuple[str, ...] = ()) -> None:
        super().__init__()
        self._question = question
        self._value = value
        self._suggestions = suggestions

    def compose(self) -> ComposeResult:
        """Add the question and the input line."""
        with Vertical():
            yield Label(self._question, markup=False)
            suggester = SuggestFromList(self._suggestions) if self._suggestions else None
            yield Input(self._value, suggester=suggester)
            if self._suggestions:
                yield Label(", ".join(self._suggestions), markup=False)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Close with the entered line."""
        self.dismiss(event.value)

    def action_leave(self) -> None:
        """Close without a text."""
        self.dismiss(None)
