"""Executable ``xacro``: the xacro library's command line, with a limit on expansion."""

from __future__ import annotations

from pathlib import Path

# Any: documents and options of the xacro library.
from typing import Any

from teleopctl.robot import bounded_xacro, over_budget


def main() -> None:
    """Run ``xacro`` on the process's command line, with a limit on macro expansion."""
    with bounded_xacro() as xacro:
        expand = xacro.process_file

        def process_file(file: str, **options: Any) -> Any:
            try:
                return expand(file, **options)
            except Exception as error:
                # xacro would print a line for each macro, of which there may be any number.
                if refusal := over_budget(Path(file), error):
                    raise SystemExit(f"xacro: {refusal.message}") from error
                raise

        vars(xacro).update(process_file=process_file)
        xacro.main()
