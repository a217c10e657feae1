"""Command line: the verbs of ``teleopctl``, their options, help, completion and output.

A verb is a plain function whose parameters are annotated with
[`Option`][teleopctl.cli.verb.Option] or [`Argument`][teleopctl.cli.verb.Argument]. This declaration
is used by the quick parser, which parses a well-formed command line without importing Typer, by
``--help``, by Tab completion, and by Typer, which reports errors of a command line. `main` finds
the module of a verb.

May import `bag`, `base`, `compat`, `control`, `diagram`, `errors`, `interfaces`, `launch`, `node`,
`nodes`, `packages`, `plugins`, `sweep`, `tf` and `wire`.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.cli.verb import (
        Argument as Argument,
        Option as Option,
        Verb as Verb,
        VerbGroup as VerbGroup,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
