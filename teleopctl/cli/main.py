"""The ``teleopctl`` command: runs the verb of a command line and returns its exit status.

The verbs are listed in the registry `teleopctl.plugins`. An entry is a
[`VerbGroup`][teleopctl.cli.verb.VerbGroup] of verbs, or a single
[`Verb`][teleopctl.cli.verb.Verb]; its module is imported only when the verb is used.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found] # typeshed leaves private modules out
import gc
import os
import sys

from teleopctl.base import __version__
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console, ros2_options
from teleopctl.cli.console import COMPLETION_VARIABLE
from teleopctl.errors import (
    EXIT_INTERRUPTED,
    DefectError,
    SystemFailureError,
    TeleopctlError,
    UnsupportedError,
    UsageError,
    did_you_mean,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import NoReturn


# Objects that may be created, beyond those deleted, before the next garbage collection.
_GARBAGE = 50_000


def main() -> NoReturn:
    """Run this process's command line and exit with its status."""
    # Imported objects stay alive: collecting garbage among them is a tenth of a short command.
    gc.disable()
    try:
        status = run(sys.argv[1:], _take_interrupts, _end)
    except KeyboardInterrupt:
        status = EXIT_INTERRUPTED
    # No cleanup is left that has to handle an interrupt.
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    if "teleopctl.base.interrupts" in sys.modules:
        from teleopctl.base import interrupts

        interrupts.clear_exec_interrupt()
    # Without this, Python collects garbage among all objects once more at exit.
    gc.freeze()
    sys.exit(status)


def _take_interrupts() -> None:
    # A script starts its background jobs with SIGINT ignored. ROS 2's programs end on SIGINT all
    # the same, and scripts rely on that. Until here Ctrl-C just ends the process, see
    # `teleopctl.__main__`.
    from teleopctl.base import interrupts

    interrupts.install_sigint_handler()


def _end(status: int) -> None:
    """Exit the process without Python's finalization, which takes 3 ms."""
    sys.stderr.flush()
    os._exit(status)


def run(
    arguments: Sequence[str],
    before_verb: Callable[[], None] | None = None,
    exit_early: Callable[[int], None] | None = None,
) -> int:
    """Run a command line and print its errors; return the exit status, unless ``exit_early`` exits.

    Args:
        arguments: Command line without the program's name.
        before_verb: Called before a verb runs; not for completion and help.
        exit_early: Called with the exit status after a verb whose group leaves nothing to clean
            up, once all output is flushed; need not return.
    """
    words = list(arguments)
    debug = bool(os.environ.get("TELEOPCTL_DEBUG"))
    while words and words[0] in ("--debug", "--version", ros2_options.BUFFERING):
        first = words.pop(0)
        if first == "--version":
            words = ["--version"]
            break
        debug = debug or first == "--debug"
    console.replace_missing_streams()
    console.tolerate_narrow_encodings()
    try:
        status = _dispatch(words, before_verb)
        sys.stdout.flush()
        if "teleopctl.base.interrupts" in sys.modules and _is_interrupt():
            status = (
                EXIT_INTERRUPTED  # swallowed by Python, and the verb ended before it came again
            )
        if exit_early is not None and _leaves_nothing(words):
            exit_early(status)
    except BrokenPipeError:
        from teleopctl.base.output import discard_output

        discard_output()
        return 0
    except KeyboardInterrupt as interrupt:
        if interrupt.args:
            console.note(str(interrupt))
        return EXIT_INTERRUPTED
    except Exception as error:  # noqa: BLE001 -- any exception is reported as one message
        if _is_interrupt(error):
            return EXIT_INTERRUPTED
        failure = error if isinstance(error, TeleopctlError) else _unexpected_error(error, words)
        if debug:
            console.traceback()
        console.error(failure)
        return failure.exit_status
    return status


def _is_interrupt(error: Exception | None = None) -> bool:
    from teleopctl.base import interrupts

    return interrupts.is_cause(error)


def _dispatch(words: list[str], before_verb: Callable[[], None] | None) -> int:
    if words == ["--version"]:
        console.out(f"teleopctl {__version__}")
        return 0
    if COMPLETION_VARIABLE in os.environ:
        from teleopctl.cli.completion import completing

        completing.print_candidates(words)
        return 0
    words = ros2_options.without_ignored_options(words)
    if _asks_for_help(words) and _show_help(words):
        return 0
    if before_verb is not None:
        before_verb()
    words = _with_verb(words)
    refuse_unknown_verb(words)
    status = _run_quickly(words)
    if status is not None:
        return status
    from teleopctl.cli import typer_app

    _collect_garbage()
    return typer_app.run(words)


def _leaves_nothing(words: Sequence[str]) -> bool:
    """Return whether nothing is left to clean up: after completion, or as the verb declares."""
    from teleopctl import plugins

    if COMPLETION_VARIABLE in os.environ:
        return True
    if not words or _asks_for_help(words):
        return False
    if plugins.find(plugins.VERBS, words[0]) is None:
        return False
    return bool(getattr(plugins.load(plugins.VERBS, words[0]), "leaves_nothing", False))


def _collect_garbage() -> None:
    """Enable garbage collection for a verb, which may run for days."""
    gc.freeze()
    # Short commands stay below this; with the default threshold, collections take 2 ms of each.
    gc.set_threshold(_GARBAGE)
    gc.enable()


def _asks_for_help(words: Sequence[str]) -> bool:
    """Return whether the words may request a help page."""
    return not words or "-h" in words or "--help" in words


def _show_help(words: Sequence[str]) -> bool:
    from teleopctl.cli import help_page

    return help_page.print_requested_page(words)


def _with_verb(words: list[str]) -> list[str]:
    """Return the words with a noun's default verb added: ``doctor -r`` is ``doctor check -r``."""
    has_none = len(words) == 1 or (len(words) > 1 and words[1].startswith("-"))
    if not has_none:
        return words
    from teleopctl import plugins

    if plugins.find(plugins.VERBS, words[0]) is None:
        return words
    alone = getattr(plugins.load(plugins.VERBS, words[0]), "alone", "")
    return [words[0], alone, *words[1:]] if alone else words


def refuse_unknown_verb(words: Sequence[str]) -> None:
    """Raise an error for a noun or verb that does not exist, without the import of Typer.

    Raises:
        UnsupportedError: The noun or verb is one of ros2.
        UsageError: The noun or verb is misspelt.
    """
    from teleopctl import plugins

    # Options before a verb are left to Typer.
    path = words[:1] if len(words) == 1 or words[1].startswith("-") else words[:2]
    if not path or path[0].startswith("-"):
        return
    nouns = {} if path[0] in plugins.VERBS.builtin else _nouns()
    if not nouns or path[0] in nouns:
        found = plugins.load(plugins.VERBS, path[0])
        verbs = getattr(found, "verbs", None)
        if verbs is None or path[-1] in verbs or len(path) == 1:
            return
    else:
        verbs, path = nouns, path[:1]
    page = f"`{' '.join([console.PROGRAM, *path[:-1]])} --help`"
    if ros2_options.is_missing_verb(words):
        raise UnsupportedError(
            f"'{' '.join(path)}' is a verb of ros2 that teleopctl does not support yet",
            hint=f"See {page} for those that it has.",
        )
    near = did_you_mean(path[-1], verbs)
    raise UsageError(f"No such command '{path[-1]}'", hint=f"{near or ''} See {page}.".strip())


def _nouns() -> dict[str, str]:
    from teleopctl.cli import declared

    return declared.nouns()


def _run_quickly(words: list[str]) -> int | None:
    """Run a command line without Typer; return None if Typer has to parse it."""
    from teleopctl import plugins

    if not words or words[0].startswith("-") or plugins.find(plugins.VERBS, words[0]) is None:
        return None
    from teleopctl.cli import quick
    from teleopctl.cli.verb import Verb, VerbGroup, call

    first, *rest = words
    verb: Verb | VerbGroup | None = plugins.load(plugins.VERBS, first)
    if isinstance(verb, VerbGroup):
        if not rest:
            return 0 if _show_help(words) else None
        second, *rest = rest
        verb = verb.verbs.get(second)
    if verb is None:
        return None
    function = verb.load()
    values = quick.parse(verb, function, rest)
    if values is None:
        return None
    _collect_garbage()
    return call(function, values) or 0


def _unexpected_error(error: Exception, words: Sequence[str]) -> TeleopctlError:
    import errno

    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        from teleopctl.base.output import discard_output

        discard_output()
        return SystemFailureError(f"Cannot write: {error.strerror}")
    if isinstance(error, OSError) and error.filename is not None:
        # Permissions, broken links and the like, which are not defects of teleopctl.
        return SystemFailureError(f"Cannot use {error.filename}: {error.strerror}")
    if isinstance(error, UnicodeEncodeError):
        # Arguments that are not valid text hold lone surrogates, which cannot be encoded.
        for word in words:
            if any("\udc80" <= character <= "\udcff" for character in word):
                return UsageError(f"{word!r} is not text in this encoding")
    return DefectError(
        f"unexpected {type(error).__name__}: {error}",
        hint="This is a defect of teleopctl; `teleopctl --debug …` shows where.",
    )
