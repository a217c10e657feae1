"""Typer application for lines that the quick parser declines: runs them, or reports errors.

Builds a Typer command tree with the requested verb only; `main` has refused unknown verbs.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Annotated, Any, Literal

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command, get_group

from teleopctl import plugins
from teleopctl.cli import declared, help_page
from teleopctl.cli.console import PROGRAM
from teleopctl.cli.typer_line import typer_line
from teleopctl.cli.verb import Option, Verb, VerbGroup, VerbParameter, call, parameters
from teleopctl.errors import TeleopctlError, UsageError

# Largest number of names in a hint, which fit in one or two lines.
_MOST_OFFERED = 12


def run(words: Sequence[str]) -> int:
    """Parse a command line with Typer and run its verb; return the exit status.

    Args:
        words: Command line after the global options.

    Raises:
        TeleopctlError: The command line is wrong (exit status 2), or the verb failed.
    """
    tree = command_tree(words)
    line = typer_line(tree, words)
    try:
        with tree.make_context(PROGRAM, line) as context:
            status = tree.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except typer.Abort:
        return 1
    except typer.TyperException as wrong:
        raise _usage_error(wrong, words) from wrong
    return status if isinstance(status, int) else 0


def command_tree(words: Sequence[str]) -> TyperGroup:
    """Return Typer's root command, with parameters only for the verb that ``words`` name.

    Raises:
        BrokenPluginError: The verb is from a plug-in that cannot be loaded.
    """
    root = _new_app()

    @root.callback()
    def teleopctl(
        version: Annotated[bool, typer.Option("--version")] = False,
        debug: Annotated[bool, typer.Option("--debug")] = False,
    ) -> None:
        """Declare the global options, which `teleopctl.cli.main` parses before Typer is loaded."""

    position, chosen = _first_word(words)
    tree = get_group(root)
    if chosen and plugins.find(plugins.VERBS, chosen) is not None:
        verb: Verb | VerbGroup = plugins.load(plugins.VERBS, chosen)
        if isinstance(verb, VerbGroup):
            tree.add_command(_group_command(verb, words[position + 1 :]), chosen)
        else:
            app = _new_app()
            _add_verb(app, chosen, verb, _typer_function(verb))
            tree.add_command(get_command(app), chosen)
    return tree


def _group_command(group: VerbGroup, words: Sequence[str]) -> TyperGroup:
    app = _new_app()

    @app.callback()
    def noun() -> None:
        """Do nothing: callback of a noun such as ``topic``, which needs a verb after it."""

    _, chosen = _first_word(words)
    if chosen in group.verbs:
        verb = group.verbs[chosen]
        _add_verb(app, chosen, verb, _typer_function(verb))
    return get_group(app)


def _add_verb(app: typer.Typer, name: str, verb: Verb, function: Callable[..., int | None]) -> None:
    app.command(
        name,
        cls=_Command,
        context_settings={
            "help_option_names": ["-h", "--help"],
            "ignore_unknown_options": verb.negative_numbers or verb.passes_everything_on,
            "allow_interspersed_args": not verb.passes_on,
        },
    )(function)


def _first_word(words: Sequence[str]) -> tuple[int, str]:
    """Return position and text of the first word that is not an option; empty text if none is."""
    for position, word in enumerate(words):
        if not word.startswith("-"):
            return position, word
    return len(words), ""


def _typer_function(verb: Verb) -> Callable[..., int | None]:
    """Return the verb's function with its declarations converted to Typer's."""
    function = verb.load()
    declared_parameters = parameters(function)
    listed = [
        inspect.Parameter(
            parameter.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=parameter.default if parameter.optional else inspect.Parameter.empty,
            annotation=_typer_annotation(parameter),
        )
        for parameter in declared_parameters
    ]

    @wraps(function)
    def run_verb(**values: object) -> int | None:
        for parameter in declared_parameters:
            _check_finite(parameter, values[parameter.name])
        return call(function, values)

    run_verb.__annotations__ = {parameter.name: parameter.annotation for parameter in listed}
    # inspect, and so Typer, uses this instead of the real signature.
    run_verb.__dict__["__signature__"] = inspect.Signature(listed)
    return run_verb


def _check_finite(parameter: VerbParameter, value: object) -> None:
    """Reject ``nan`` and ``inf``, which Typer accepts as floats, but which are no time or rate."""
    if isinstance(value, float) and not math.isfinite(value):
        declaration = parameter.declaration
        name = parameter.name.upper()
        if isinstance(declaration, Option):
            name = declaration.flags[-1]
        raise typer.BadParameter(f"{value} is not a finite number.", param_hint=f"'{name}'")


def _typer_annotation(parameter: VerbParameter) -> object:
    declaration = parameter.declaration
    value_type: Any = parameter.type
    if declaration.choices:
        value_type = Literal[declaration.choices]
    if parameter.many:
        value_type = list[value_type]
    if parameter.optional and parameter.default is None:
        value_type = value_type | None
    if isinstance(declaration, Option):
        read = typer.Option(*declaration.flags)
    else:
        # Name of the argument in the error message if it is missing.
        read = typer.Argument(metavar=declaration.metavar or parameter.name.upper())
    return Annotated[value_type, read]


class _Command(TyperCommand):
    """Typer command of a verb, whose help is the page of `help_page`."""

    def get_help(self, ctx: Any) -> str:  # Any: a class of the library that Typer vendors
        """Return the help page, for spellings of ``--help`` that only Typer parses."""
        path = ctx.command_path.split()[1:]
        found = declared.find_declaration(path)
        return "" if found is None else help_page.page_text(path, found)


def _new_app() -> typer.Typer:
    return typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )


def _usage_error(wrong: typer.TyperException, words: Sequence[str]) -> TeleopctlError:
    context = getattr(wrong, "ctx", None)
    path = context.command_path if context is not None else _verb_path(words)
    return UsageError(
        # The library behind Typer's types begins messages about wrong values with "Value error".
        wrong.format_message().replace("Value error, ", ""),
        hint=f"{_missing_candidates(wrong, words)}See `{path} --help`.",
    )


def _verb_path(words: Sequence[str]) -> str:
    """Return the program's name with the noun and the verb of a command line."""
    verb = plugins.load(plugins.VERBS, words[0]) if not words[0].startswith("-") else None
    known = [*words[:1], *words[1:2]] if isinstance(verb, VerbGroup) else words[: verb is not None]
    return " ".join([PROGRAM, *known])


def _missing_candidates(wrong: typer.TyperException, words: Sequence[str]) -> str:
    """Return the completion candidates of a missing argument as text; empty without a terminal.

    The output of a script must not depend on the live graph.
    """
    is_missing = type(wrong).__name__ == "MissingParameter"
    if not (is_missing and sys.stdin.isatty() and sys.stderr.isatty()):
        return ""
    from teleopctl.cli.completion import completing

    offered = [each for each in completing.candidates(words, "") if not each.startswith("-")]
    more = len(offered) - _MOST_OFFERED
    names = ", ".join(offered[:_MOST_OFFERED]) + (f" and {more} more" if more > 0 else "")
    return f"There are {names}.\n  " if names else ""
