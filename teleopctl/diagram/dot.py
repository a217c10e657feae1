"""A diagram for Graphviz, in its language dot."""

from __future__ import annotations

from teleopctl.diagram.model import Diagram

_SHAPES = {"node": "ellipse", "topic": "box", "label": "plaintext"}


def to_dot(diagram: Diagram) -> str:
    """Return a diagram in Graphviz's language."""
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
