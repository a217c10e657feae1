"""Help pages of the program, of nouns and of verbs, made from their declarations.

Only declarations are imported: neither the verb nor a library for parsing arguments or drawing.
"""

from __future__ import annotations

import os
import sys

from teleopctl import plugins
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console, declared, ros2_options
from teleopctl.cli.console import PROGRAM
from teleopctl.cli.declared import DeclaredVerb
from teleopctl.cli.verb import Argument, Option, VerbGroup, VerbParameter

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    # A line: texts, each with its colour, "" for none.
    Line = tuple[tuple[str, str], ...]
    # A row of a table: name and description.
    Row = tuple[str, str]

FLAGS = ("-h", "--help")

_HEADING = "\x1b[1m"
_NAME = "\x1b[36m"
_HELP = ("-h, --help", "Show this message and exit.")
# Longer names have a line of their own, so that the column of descriptions stays wide.
_WIDEST_NAME = 30
# Longer lines are hard to read, and shorter ones have no room for two columns.
_WIDEST_PAGE, _NARROWEST_PAGE = 100, 40


def print_requested_page(words: Sequence[str]) -> bool:
    """Print the help page that a command line requests; return False if it requests none.

    Args:
        words: Command line after the global options.
    """
    page = _asked(words)
    if page is None:
        return False
    for line in page:
        console.out_coloured(*line)
    return True


def page_text(path: Sequence[str], found: DeclaredVerb | VerbGroup) -> str:
    """Return the help page of a noun or a verb as text without colours."""
    page = _of_group(path, found) if isinstance(found, VerbGroup) else _of_verb(path, found)
    return "\n".join("".join(text for text, _ in line) for line in page)


def _asked(words: Sequence[str]) -> list[Line] | None:
    if not words or words[0] in FLAGS:
        return _of_program()
    found = declared.find_declaration(words[:1])
    if found is None:
        return None
    if isinstance(found, DeclaredVerb):
        return _of_verb(words[:1], found) if _asks(found, words[1:]) else None
    if len(words) == 1 or words[1] in FLAGS:
        return _of_group(words[:1], found)
    verb = declared.find_declaration(words[:2]) if words[1] in found.verbs else None
    if isinstance(verb, DeclaredVerb) and _asks(verb, words[2:]):
        return _of_verb(words[:2], verb)
    return None


def _asks(found: DeclaredVerb, words: Sequence[str]) -> bool:
    """Return whether ``--help`` is among a verb's own words, not among those passed on."""
    if found.verb.passes_everything_on:
        return bool(words) and words[0] in FLAGS
    with_value = {
        flag
        for parameter in found.parameters
        if isinstance(parameter.declaration, Option) and parameter.takes_value
        for flag in parameter.declaration.flags
    }
    remaining = iter(words)
    for word in remaining:
        if word in FLAGS:
            return True
        if word == "--" or (found.verb.passes_on and not word.startswith("-")):
            return False
        if word in with_value:
            next(remaining, None)
    return False


# Verbs by purpose, as on the cheat sheet; verbs of plug-ins have a line each too, and all others
# share the last lines.
PURPOSES = {
    "Start": ("run", "launch", "ps", "logs", "stop", "pkg"),
    "See": ("view", "top", "graph", "camera"),
    "Look": (
        *("topic", "node", "service", "action", "param", "logger", "tf", "interface", "doctor"),
    ),
    "Move": ("move", "drive", "control", "kinematics"),
    "Record": ("bag", "episode"),
    "Robot": ("robot", "sim"),
}
"""Verbs that the program's page explains, by purpose."""
_REST = "Advanced"
_EXAMPLES = (
    "launch -d sim.yaml         # a robot in simulation, and its page",
    "topic echo /joint_states   # what its joints do",
    "stop --all                 # end everything",
)


def _of_program() -> list[Line]:
    nouns = declared.nouns()
    shown = {name for names in PURPOSES.values() for name in names}
    added = [name for name in nouns if name not in plugins.VERBS.summaries]
    groups = {**PURPOSES, **({"Plug-ins": added} if added else {})}
    names = [name for group in groups.values() for name in group]
    left = max(map(len, (*groups, _REST)))
    width = max(map(len, names))
    purpose = f"The ROS 2 workflow in one pip install. `{PROGRAM} help VERB` explains a verb."
    lines: list[Line] = [
        *_usage("[--debug] VERB [ARGS]..."),
        *(((f"  {line}", ""),) for line in _wrapped(purpose, _width() - 2)),
        (),
    ]
    for title, group in groups.items():
        for name in group:
            first, *more = _wrapped(nouns[name], _width() - left - width - 6)
            lines.append(
                (
                    (f"  {title:{left}}  ", _HEADING),
                    (name, _NAME),
                    (f"{' ' * (width - len(name))}  {first}", ""),
                )
            )
            lines += [((" " * (left + width + 6) + line, ""),) for line in more]
            title = ""
    rest = [name for name in nouns if name not in shown and name not in added]
    for number, line in enumerate(_wrapped(", ".join(rest), _width() - left - 4)):
        title = "" if number else _REST
        lines.append(((f"  {title:{left}}  ", _HEADING), (line, _NAME)))
    lines.append(())
    lines += [((f"  {PROGRAM} {line}", ""),) for line in _EXAMPLES]
    lines.append(((f"  The page in the browser is RViz and rqt: `{PROGRAM} view`.", ""),))
    return lines


def _of_group(path: Sequence[str], group: VerbGroup) -> list[Line]:
    more = [ros2_options.EXPLANATION] if path[0] in ros2_options.GROUPS else []
    options: list[Row] = []
    if group.alone:
        # The noun alone is this verb, with its options.
        alone = declared.find_declaration([*path, group.alone])
        assert isinstance(alone, DeclaredVerb)
        options = [
            (_name(each), _text(each))
            for each in alone.parameters
            if isinstance(each.declaration, Option)
        ]
    return [
        *_usage(*path, "[OPTIONS] COMMAND [ARGS]..."),
        *_paragraphs([group.help]),
        *_table("Options", [*options, _HELP]),
        *_table("Commands", [(name, verb.help) for name, verb in group.verbs.items()]),
        *_paragraphs(more),
    ]


def _of_verb(path: Sequence[str], found: DeclaredVerb) -> list[Line]:
    arguments = [each for each in found.parameters if isinstance(each.declaration, Argument)]
    options = [each for each in found.parameters if not isinstance(each.declaration, Argument)]
    usage = _usage(*path, "[OPTIONS]", *map(_placeholder, arguments))
    examples: list[Line] = [
        ((f"  {line.replace('teleopctl ', f'{PROGRAM} ')}", ""),) for line in found.verb.examples
    ]
    return [
        *usage,
        *_paragraphs([found.verb.help, *found.more]),
        *_table("Arguments", [(_name(each), _text(each)) for each in arguments]),
        *_table("Options", [*((_name(each), _text(each)) for each in options), _HELP]),
        # Examples are not wrapped, so that they can be copied.
        *([(), (("Examples:", _HEADING),), *examples] if examples else []),
    ]


def _usage(*words: str) -> list[Line]:
    first, *more = _wrapped(" ".join([PROGRAM, *words]), _width() - len("Usage: "))
    indent = " " * len("Usage: ")
    return [(("Usage:", _HEADING), (f" {first}", "")), *(((indent + line, ""),) for line in more)]


def _paragraphs(texts: Iterable[str]) -> list[Line]:
    lines: list[Line] = []
    for text in texts:
        lines.append(())
        lines += [((f"  {line}", ""),) for line in _wrapped(text, _width() - 2)]
    return lines


def _table(title: str, rows: Iterable[Row]) -> list[Line]:
    rows = list(rows)
    if not rows:
        return []
    most = min(_WIDEST_NAME, _width() // 2 - 6)
    widest = max((len(name) for name, _ in rows if len(name) <= most), default=0)
    indent = " " * (2 + widest + 2)
    lines: list[Line] = [(), ((f"{title}:", _HEADING),)]
    for name, text in rows:
        first, *more = _wrapped(text, _width() - len(indent)) or [""]
        if len(name) > widest:
            lines.append((("  ", ""), (name, _NAME)))
            lines.append(((indent + first, ""),))
        else:
            gap = " " * (len(indent) - 2 - len(name))
            lines.append((("  ", ""), (name, _NAME), ((gap + first).rstrip(), "")))
        lines += [((indent + line, ""),) for line in more]
    return lines


def _placeholder(argument: VerbParameter) -> str:
    """Return an argument's placeholder for the usage line: ``TOPIC``, ``[TYPE]`` or ``NAME...``."""
    name = argument.declaration.metavar or argument.name.upper()
    if "[" in name:  # the metavar shows optional parts itself
        return name
    if argument.many and not name.endswith("..."):
        name += "..."
    return f"[{name}]" if argument.optional else name


def _name(parameter: VerbParameter) -> str:
    declaration = parameter.declaration
    value = declaration.metavar or ("NAME" if declaration.choices else "")
    if not isinstance(declaration, Option):
        value = value or parameter.name.upper()
        return value if parameter.type is str else f"{value} <{parameter.type.__name__}>"
    # Short flags first, so that the long ones are aligned.
    flags = ", ".join(sorted(declaration.flags, key=lambda flag: flag.startswith("--")))
    if parameter.type is bool:
        return flags
    return f"{flags} {value or f'<{parameter.type.__name__}>'}{'...' if parameter.many else ''}"


def _text(parameter: VerbParameter) -> str:
    declaration = parameter.declaration
    text = declaration.help
    if declaration.choices:
        text += f" One of {', '.join(declaration.choices)}."
    if not parameter.optional:
        return f"{text}  [required]"
    if parameter.default in (None, "") or parameter.type is bool:
        return text
    return f"{text}  [default: {parameter.default}]"


def _width() -> int:
    """Return the width of the page in columns."""
    chosen = os.environ.get("COLUMNS", "")
    if chosen.isdecimal():
        columns = int(chosen)
    else:
        try:
            columns = os.get_terminal_size(sys.stdout.fileno()).columns
        except (OSError, ValueError):
            columns = 80
    return max(_NARROWEST_PAGE, min(columns or 80, _WIDEST_PAGE))


def _wrapped(text: str, width: int) -> list[str]:
    """Wrap a text into lines; `textwrap` takes longer to import than the rest of the page."""
    lines: list[str] = []
    # A part in brackets at the end follows two blanks, and is not wrapped.
    for part in text.split("  "):
        gap = "  "
        for word in [part] if part.startswith("[") else part.split(" "):
            if lines and len(lines[-1]) + len(gap) + len(word) <= width:
                lines[-1] += gap + word
            else:
                lines.append(word)
            gap = " "
    return lines
