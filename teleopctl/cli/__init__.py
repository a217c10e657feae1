"""Floor 6: the verbs of the command line.

A verb is a plain function whose parameters carry [`Option`][teleopctl.cli.verb.Option] or
[`Argument`][teleopctl.cli.verb.Argument]. That one declaration is read by the quick parser, which
takes a well-formed command line without loading anything, by the page of ``--help``, by Tab, and by
Typer, which says what is wrong with a line. `main` says which module a verb lives in.
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
