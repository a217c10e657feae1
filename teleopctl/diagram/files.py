"""A picture as files: for Graphviz, as SVG, and as PDF where Graphviz is installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

from teleopctl.errors import SystemFailureError

_DOT_PATIENCE_S = 30.0


def write_files(base: Path, dot: str, svg: str, say: Callable[[str], object]) -> list[Path]:
    """Write a diagram's files.

    Args:
        base: Path of the files without their endings.
        dot: The picture in Graphviz's language.
        svg: The picture.
        say: Called with why there is no PDF.

    Returns:
        The files: ``.gv`` and ``.svg``, and ``.pdf`` where Graphviz's ``dot`` is installed.

    Raises:
        SystemFailureError: A file cannot be written, or ``dot`` fails.
    """
    graph = _written(base, ".gv", dot)
    files = [graph, _written(base, ".svg", svg)]
    program = shutil.which("dot")
    if program is None:
        say("No PDF: Graphviz's program `dot` is not installed (apt install graphviz)")
    else:
        files.append(_pdf(program, graph, _file(base, ".pdf")))
    return files


def _file(base: Path, ending: str) -> Path:
    # Not with_suffix: a time in the name has dots too.
    return base.with_name(base.name + ending)


def _written(base: Path, ending: str, text: str) -> Path:
    file = _file(base, ending)
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SystemFailureError(f"Cannot write {file}: {error.strerror or error}") from error
    return file


def _pdf(program: str, graph: Path, pdf: Path) -> Path:
    try:
        done = subprocess.run(
            [program, "-Tpdf", str(graph), "-o", str(pdf)],
            capture_output=True,
            text=True,
            check=False,
            timeout=_DOT_PATIENCE_S,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SystemFailureError(f"{program} failed: {error}") from error
    if done.returncode != 0:
        raise SystemFailureError(f"{program} failed: {done.stderr.strip()}")
    return pdf
