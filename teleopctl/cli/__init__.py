"""Command line: the verbs of ``teleopctl``, their options, help, completion and output.

A verb is a plain function whose parameters carry [`Option`][teleopctl.cli.verb.Option] or
[`Argument`][teleopctl.cli.verb.Argument]. That one declaration is read by the quick parser, which
takes a well-formed command line without loading anything, by ``--help``, by Tab completion, and by
Typer, which reports the faults of a command line. `main` determines the module of a verb.

May import `bag`, `compat`, `control`, `diagram`, `interfaces`, `launch`, `node`, `nodes`, `sweep`,
`tf` and `wire`, besides `base`, `errors`, `packages` and `plugins`.
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
