"""Typer's side of the command line: help, usage errors and completion.

Builds one Typer command tree with the wanted verb for real and a placeholder for each other one,
so that ``--help`` lists all of them and imports none.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from importlib import import_module
from typing import Annotated, Any, Literal, NoReturn

import typer
from typer.core import TyperGroup
from typer.main import get_command, get_group, get_install_completion_arguments

from teleopctl.cli import candidates
from teleopctl.cli.program import COMPLETION_VARIABLE, PROGRAM
from teleopctl.cli.verb import Group, Option, Parameter, Verb, epilog, parameters
from teleopctl.errors import TeleopctlError


def run(table: Mapping[str, tuple[str, str]], words: Sequence[str]) -> int:
    """Parse and run a command line.

    Args:
        table: Module and one-line help of each verb.
        words: The command line behind the global options.

    Returns:
        The exit status.

    Raises:
        TeleopctlError: The command line is wrong (exit status 2), or the verb failed.
    """
    tree = command_tree(table, words)
    line = _spread_lists(tree, words)
    if not line or (len(line) == 1 and isinstance(tree.commands.get(line[0]), TyperGroup)):
        line.append("--help")
    try:
        with tree.make_context(PROGRAM, line) as context:
            status = tree.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except typer.Abort:
        return 1
    except typer.TyperException as wrong:
        raise _usage_error(wrong) from wrong
    return status if isinstance(status, int) else 0


def answer_shell(table: Mapping[str, tuple[str, str]], words: Sequence[str]) -> NoReturn:
    """Do what the completion variable in the environment asks for, and end the process.

    Args:
        table: Module and one-line help of each verb.
        words: The command line so far, to know which verb to load.
    """
    get_install_completion_arguments()  # makes Typer's shells known, which it does not do alone
    command_tree(table, words).main(prog_name=PROGRAM, complete_var=COMPLETION_VARIABLE)
    sys.exit(0)


def command_tree(table: Mapping[str, tuple[str, str]], words: Sequence[str]) -> TyperGroup:
    """The root command, with only the verb that ``words`` name really loaded."""
    root = _new_app()

    @root.callback(
        help="The ROS 2 workflow in one pip install.",
        epilog="Each verb explains itself with --help.",
    )
    def teleopctl(
        version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
        debug: Annotated[
            bool, typer.Option("--debug", help="Show the traceback of an error.")
        ] = False,
    ) -> None:
        """Both options are read before Typer is loaded; they stand here for ``--help``."""

    for name, (_, short_help) in table.items():
        root.command(name, help=short_help)(_placeholder)
    tree = get_group(root)
    position, chosen = _first_word(words)
    if chosen in table:
        module = import_module(table[chosen][0])
        verb: Verb | None = getattr(module, "VERB", None)
        if verb is None:
            tree.add_command(_group_command(module.GROUP, words[position + 1 :]), chosen)
        else:
            app = _new_app()
            _add_verb(app, chosen, verb, _typer_function(verb))
            tree.add_command(get_command(app), chosen)
    return tree


def _group_command(group: Group, words: Sequence[str]) -> TyperGroup:
    app = _new_app()

    @app.callback(help=group.help)
    def noun() -> None:
        """A noun does nothing without a verb."""

    _, chosen = _first_word(words)
    for verb_name, verb in group.verbs.items():
        function = _typer_function(verb) if verb_name == chosen else _placeholder
        _add_verb(app, verb_name, verb, function)
    return get_group(app)


def _spread_lists(tree: TyperGroup, words: Sequence[str]) -> list[str]:
    """Turn ``--activate a b``, as `argparse` reads it, into ``--activate a --activate b``."""
    command: Any = tree
    spread: list[str] = []
    flag: str | None = None
    for word in words:
        if isinstance(command, TyperGroup) and word in command.commands:
            command = command.commands[word]
        elif word.startswith("-"):
            lists = {name for option in command.params if option.multiple for name in option.opts}
            flag = word if word in lists else None
            if flag:
                continue
        elif flag:
            spread.append(flag)
        spread.append(word)
    return spread


def _add_verb(app: typer.Typer, name: str, verb: Verb, function: Callable[..., int | None]) -> None:
    app.command(
        name,
        help=_long_help(verb, function),
        epilog=epilog(verb.examples),
        context_settings={
            "help_option_names": ["-h", "--help"],
            "ignore_unknown_options": verb.negative_numbers,
            "allow_interspersed_args": not verb.passes_on,
        },
    )(function)


def _first_word(words: Sequence[str]) -> tuple[int, str]:
    """Position and text of the first word that is no option; an empty text if there is none."""
    for position, word in enumerate(words):
        if not word.startswith("-"):
            return position, word
    return len(words), ""


def _long_help(verb: Verb, function: Callable[..., object]) -> str:
    """The one-line help and, for the verb in hand, what its docstring adds to that."""
    if function is _placeholder:
        return verb.help
    _, _, more = (inspect.getdoc(function) or "").partition("\n\n")
    more = more.partition("Args:")[0].strip()
    return f"{verb.help}\n\n{more}" if more else verb.help


def _typer_function(verb: Verb) -> Callable[..., int | None]:
    """The verb's function with its declarations spelt in Typer's words."""
    function = verb.load()
    signature = inspect.signature(function)
    declared = [
        signature.parameters[parameter.name].replace(annotation=_typer_annotation(parameter))
        for parameter in parameters(function)
    ]

    @wraps(function)
    def call(**values: object) -> int | None:
        return function(**values)

    call.__annotations__ = {parameter.name: parameter.annotation for parameter in declared}
    # What inspect, and so Typer, takes in place of the real signature.
    call.__dict__["__signature__"] = signature.replace(parameters=declared)
    return call


def _typer_annotation(parameter: Parameter) -> object:
    declaration = parameter.declaration
    value_type: Any = parameter.type
    live = getattr(candidates, declaration.complete) if declaration.complete else None
    if isinstance(declaration, Option):
        if declaration.choices:
            value_type = Literal[declaration.choices]
        if parameter.many:
            value_type = list[value_type]
        if parameter.optional and parameter.default is None:
            value_type = value_type | None
        return Annotated[
            value_type,
            typer.Option(
                *declaration.flags,
                help=declaration.help,
                metavar=declaration.metavar,
                autocompletion=live,
            ),
        ]
    if parameter.many:
        value_type = list[value_type]
    if parameter.optional and parameter.default is None:
        value_type = value_type | None
    return Annotated[
        value_type,
        typer.Argument(
            help=declaration.help,
            metavar=declaration.metavar or parameter.name.upper(),
            autocompletion=live,
        ),
    ]


def _new_app() -> typer.Typer:
    return typer.Typer(
        add_completion=False,
        rich_markup_mode=_markup_mode(),
        context_settings={"help_option_names": ["-h", "--help"]},
    )


def _markup_mode() -> Literal["rich"] | None:
    """Boxes and colours on a terminal; plain help in a pipe, and rich is not loaded."""
    return "rich" if sys.stdout.isatty() else None


def _placeholder() -> None:
    """Stands for a verb that is listed and not loaded."""


def _usage_error(wrong: typer.TyperException) -> TeleopctlError:
    context = getattr(wrong, "ctx", None)
    path = context.command_path if context is not None else PROGRAM
    return TeleopctlError(
        # "Value error" is how the library behind Typer's types introduces any wrong value.
        wrong.format_message().replace("Value error, ", ""),
        hint=f"see `{path} --help`",
        exit_status=getattr(wrong, "exit_code", 2),
    )
