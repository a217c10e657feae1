r"""Text with substitutions, ``$(name argument …)``, in the grammar of ROS 2's launch front ends.

A substitution's arguments are separated by blanks. An argument is bare, ``'quoted'`` or
``"quoted"``, and may contain substitutions. A backslash escapes ``$``, quotes, parentheses, blanks
and itself; before any other character it is literal, so that Windows paths stay intact.
"""

from __future__ import annotations

from teleopctl.base.budget import joined
from teleopctl.base.typed import Callable, Protocol
from teleopctl.launch.model.records import dataclass

_ESCAPABLE = frozenset("$'\"\\() \t\n")
_QUOTES = frozenset("'\"")


class TemplateError(ValueError):
    """Text that violates the grammar of substitutions."""


@dataclass(frozen=True, slots=True)
class SubstitutionArgument:
    """One argument of a substitution's call, with its quotation mark.

    Attributes:
        template: Text of the argument.
        quote: Quotation mark around the argument, or an empty string.
    """

    template: Template
    quote: str = ""


@dataclass(frozen=True, slots=True)
class Call:
    """Call of a substitution in a launch file, ``$(name argument …)``, not yet evaluated.

    Attributes:
        name: Name of the substitution, the word after ``$(``.
        arguments: Arguments after the name.
        source: Whole substitution as written, for messages.
    """

    name: str
    arguments: tuple[SubstitutionArgument, ...]
    source: str


class ComputedText(Protocol):
    """Interface of substitutions of Python launch files, which evaluate themselves."""

    @property
    def source(self) -> str:
        """Description of the substitution, for error messages."""

    # object: the evaluation's context, whose class is in a higher layer.
    def evaluate(self, context: object) -> str:
        """Return the substitution's text in a launch context."""


@dataclass(frozen=True, slots=True)
class Template:
    """Text of a launch file with substitutions, parsed and not yet evaluated.

    Attributes:
        parts: Literal texts and substitutions, in order.
        source: Text as written.
    """

    parts: tuple[str | Call | ComputedText, ...]
    source: str

    def render(self, substitute: Callable[[Call | ComputedText], str]) -> str:
        """Return the text, with each substitution replaced by what a function returns for it.

        Raises:
            BudgetError: The text is too long.
        """
        return joined([part if isinstance(part, str) else substitute(part) for part in self.parts])

    @property
    def is_literal(self) -> bool:
        """Whether the text has no substitution."""
        return all(isinstance(part, str) for part in self.parts)

    @property
    def variable(self) -> str | None:
        """Name of the launch configuration if the text is just ``$(var NAME)``; else None."""
        match self.parts:
            case (Call("var", (SubstitutionArgument(name), *_)),) if name.is_literal:
                return name.source
        return None


def parse(text: str) -> Template:
    """Parse a text with ``$(…)`` substitutions to a template.

    Raises:
        TemplateError: A substitution is not closed or has no name, or a quote is not closed.
    """
    return _Parser(text).whole()


def literal(text: str) -> Template:
    """Return a template that stands for a fixed text, whatever characters are in it."""
    return Template(parts=(text,) if text else (), source=text)


class _Parser:
    """Recursive descent parser of a text with substitutions."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0

    def whole(self) -> Template:
        return self._template(lambda _: False)

    def _peek(self) -> str:
        return self._text[self._at] if self._at < len(self._text) else ""

    def _template(self, ends: Callable[[str], bool]) -> Template:
        start = self._at
        parts: list[str | Call | ComputedText] = []
        literal_text: list[str] = []
        while self._at < len(self._text) and not ends(self._peek()):
            character = self._peek()
            following = self._text[self._at + 1 : self._at + 2]
            if character == "\\" and following in _ESCAPABLE:
                literal_text.append(following)
                self._at += 2
            elif character == "$" and following == "(":
                if literal_text:
                    parts.append("".join(literal_text))
                    literal_text.clear()
                parts.append(self._call())
            else:
                literal_text.append(character)
                self._at += 1
        if literal_text:
            parts.append("".join(literal_text))
        return Template(parts=tuple(parts), source=self._text[start : self._at])

    def _call(self) -> Call:
        start = self._at
        self._at += 2
        self._skip_blanks()
        name_start = self._at
        while self._peek().isalnum() or self._peek() in ("-", "_"):
            self._at += 1
        name = self._text[name_start : self._at]
        if not name:
            raise TemplateError(f"'{self._text[start:]}' has no name after '$('")
        arguments: list[SubstitutionArgument] = []
        while True:
            blanks = self._skip_blanks()
            if not self._peek():
                raise TemplateError(f"'{self._text[start:]}' has no closing ')'")
            if self._peek() == ")":
                self._at += 1
                return Call(name, tuple(arguments), self._text[start : self._at])
            if not blanks:
                raise TemplateError(
                    f"'{self._text[start : self._at + 1]}': expected a blank or ')' "
                    f"before '{self._peek()}'"
                )
            arguments.append(self._argument())

    def _argument(self) -> SubstitutionArgument:
        quote = self._peek()
        if quote in _QUOTES:
            start = self._at
            self._at += 1
            template = self._template(lambda character: character == quote)
            if self._peek() != quote:
                raise TemplateError(f"{self._text[start:]} has no closing {quote}")
            self._at += 1
            return SubstitutionArgument(template, quote)
        depth = 0

        def ends(character: str) -> bool:
            # Parentheses may be nested in an argument, as in $(eval (1 + 2) * 3).
            nonlocal depth
            if character == "(":
                depth += 1
            elif character == ")":
                depth -= 1
            return depth < 0 or (depth == 0 and character.isspace())

        return SubstitutionArgument(self._template(ends))

    def _skip_blanks(self) -> bool:
        start = self._at
        while self._peek().isspace():
            self._at += 1
        return self._at > start
