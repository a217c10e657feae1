"""Floor 6: the verbs of the command line.

A verb is a plain function whose parameters carry [`Option`][teleopctl.cli.verb.Option] or
[`Argument`][teleopctl.cli.verb.Argument]. Two readers understand that one declaration: the
quick parser, which takes a well-formed command line without loading anything, and Typer, which
does help, error messages and completion. `main` says which module a verb lives in.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.cli.verb import (
        Argument as Argument,
        Group as Group,
        Option as Option,
        Verb as Verb,
    )
else:
    from teleopctl.lazy import attach

    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "verb": "Argument Group Option Verb",
        },
    )
