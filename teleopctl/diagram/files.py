"""Diagrams as text and files: Graphviz, SVG, and PDF where Graphviz is installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from html import escape
from pathlib import Path

from teleopctl.diagram.layout import (
    LINE_HEIGHT,
    BoxRectangle,
    Diagram,
    DiagramBox,
    DiagramLayout,
    Point,
    lay_out,
)
from teleopctl.errors import SystemFailureError

_SHAPES = {"node": "ellipse", "topic": "box", "label": "plaintext"}


def format_dot(diagram: Diagram) -> str:
    """Return a diagram as text in Graphviz's DOT language."""
    labels = {box.key for box in diagram.boxes if box.kind == "label"}
    lines = ["digraph graph_of_nodes {", "  rankdir=LR;"]
    for box in diagram.boxes:
        shape = _SHAPES.get(box.kind, "box")
        lines.append(f"  {_quoted(box.key)} [label={_quoted(box.text)}, shape={shape}];")
    for edge in diagram.edges:
        ends = ""
        if edge.target in labels:
            ends = " [dir=none]"
        elif edge.both and edge.source not in labels:
            ends = " [dir=both]"
        lines.append(f"  {_quoted(edge.source)} -> {_quoted(edge.target)}{ends};")
    return "\n".join([*lines, "}", ""])


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


# Colours for light and dark backgrounds.
_FILLS = {"node": "#2b7fc4", "topic": "#5c6773", "label": ""}
_TEXT = "#ffffff"
_ARROW = "#8a94a0"
_HEAD_LENGTH, _HEAD_WIDTH = 9.0, 4.0


def to_svg(diagram: Diagram, attributes: Callable[[DiagramBox], str] | None = None) -> str:
    """Lay a diagram out, and return it as the text of an SVG file.

    The text is a complete file, and can also be inserted into an HTML page: it has no styles or
    identifiers that could conflict with those of the page. Labels have the page's text colour.

    Args:
        diagram: The diagram.
        attributes: Function that returns attributes for the SVG element of a box; None for none.
    """
    layout = lay_out(diagram)
    width, height = _text_of(layout.width), _text_of(layout.height)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">'
    ]
    parts += _arrows(diagram, layout)
    for box in diagram.boxes:
        drawn = _box(box, layout.places[box.key])
        given = attributes(box) if attributes is not None else ""
        parts.append(f"<g {given}>{drawn}</g>" if given else drawn)
    return "\n".join([*parts, "</svg>", ""])


def _arrows(diagram: Diagram, layout: DiagramLayout) -> list[str]:
    labels = {box.key for box in diagram.boxes if box.kind == "label"}
    drawn = []
    for edge, route in zip(diagram.edges, layout.routes, strict=True):
        drawn.append(f'<path d="{_curve(route)}" fill="none" stroke="{_ARROW}"/>')
        ends = [(route[-2], route[-1])] if edge.target not in labels else []
        if edge.both and edge.source not in labels:
            ends.append((route[1], route[0]))
        heads = "".join(_head(before, end) for before, end in ends)
        if heads:
            drawn.append(f'<path d="{heads}" fill="{_ARROW}"/>')
    return drawn


def _curve(route: list[Point]) -> str:
    """Straight where it is level, else bent so that it leaves and arrives level."""
    (x, y), *others = route
    words = [f"M{_text_of(x)} {_text_of(y)}"]
    for next_x, next_y in others:
        if abs(next_y - y) < 0.5 or abs(next_x - x) < 0.5:
            words.append(f"L{_text_of(next_x)} {_text_of(next_y)}")
        else:
            middle = _text_of((x + next_x) / 2)
            words.append(
                f"C{middle} {_text_of(y)} {middle} {_text_of(next_y)} "
                f"{_text_of(next_x)} {_text_of(next_y)}"
            )
        x, y = next_x, next_y
    return "".join(words)


def _head(before: Point, end: Point) -> str:
    """The head of an arrow, which arrives level."""
    x, y = end
    back = x - _HEAD_LENGTH if before[0] <= x else x + _HEAD_LENGTH
    return (
        f"M{_text_of(x)} {_text_of(y)}L{_text_of(back)} {_text_of(y - _HEAD_WIDTH)}"
        f"L{_text_of(back)} {_text_of(y + _HEAD_WIDTH)}Z"
    )


def _box(box: DiagramBox, place: BoxRectangle) -> str:
    fill = _FILLS.get(box.kind, _FILLS["topic"])
    x, y, width, height = map(_text_of, place)
    frame = ""
    if fill:
        radius = _text_of(place.height / 2 if box.kind == "node" else 3)
        frame = (
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" fill="{fill}"/>'
        )
    lines = box.text.split("\n")
    middle = _text_of(place.x + place.width / 2)
    first = place.y + place.height / 2 - LINE_HEIGHT * (len(lines) - 1) / 2 + 4
    texts = [
        f'<text x="{middle}" y="{_text_of(first + LINE_HEIGHT * number)}" text-anchor="middle" '
        f'fill="{_TEXT if fill else "currentColor"}">{escape(line)}</text>'
        for number, line in enumerate(lines)
    ]
    return frame + "".join(texts)


def _text_of(number: float) -> str:
    return f"{number:.1f}".removesuffix(".0")


_DOT_PATIENCE_S = 30.0


def write_diagram_files(base: Path, dot: str, svg: str, say: Callable[[str], object]) -> list[Path]:
    """Write a diagram as ``.gv`` and ``.svg``, and ``.pdf`` with Graphviz; return the files' paths.

    Args:
        base: Path of the files without suffix.
        dot: Text of the diagram in Graphviz's language.
        svg: Text of the diagram as SVG.
        say: Function called with the reason if no PDF is written.

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
    # Not with_suffix: a time in the name contains dots too.
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
