"""The frames of a tree as text: sentences, YAML and a graph, as tf2's tools read them."""

from typing import NamedTuple

from teleopctl.interfaces import to_seconds
from teleopctl.tf.tree import FrameTree

# tf2 takes no shorter time than this for the rate of a frame.
_SHORTEST_NS = 100_000
_NOBODY = "default_authority"


class _Known(NamedTuple):
    """What a tree knows of a frame over time, in seconds."""

    rate: float
    newest: float
    oldest: float


def as_string(tree: FrameTree) -> str:
    """Return a sentence for each frame that has a parent."""
    return "".join(
        f"Frame {child} exists with parent {parent}.\n" for child, parent in tree.parents()
    )


def as_yaml(tree: FrameTree) -> str:
    """Return the frames that have a parent and what is known of each."""
    lines = []
    for child, parent in tree.parents():
        known = _known(tree, child)
        _, is_static = tree.span(child) or (0, True)
        lines.append(
            f"{child}: \n  parent: '{parent}'\n"
            f"  broadcaster: '{tree.authority(child) or _NOBODY}'\n"
            f"  rate: {known.rate:.3f}\n"
            f"  most_recent_transform: {known.newest:.6f}\n"
            f"  oldest_transform: {known.oldest:.6f}\n"
            f"  buffer_length: {known.newest - known.oldest:.3f}\n"
            f"  is_static: {str(is_static).lower()}\n"
        )
    return "".join(lines) or "[]"


def as_dot(tree: FrameTree, now: int = 0) -> str:
    """Return the frames as a graph for Graphviz.

    Args:
        tree: The frames.
        now: The time from which ages are counted, in nanoseconds; 0 to leave them out.
    """
    parents = dict(tree.parents())
    lines = ["digraph G {"]
    if not tree.frames():
        lines.append('"no tf data recieved"')  # tf2's word
    for child, parent in parents.items():
        known = _known(tree, child)
        age = f"( {to_seconds(now) - known.newest:.3f} sec old)" if now else ""
        label = "".join(
            f"{line}\\n"
            for line in (
                f"Broadcaster: {tree.authority(child) or _NOBODY}",
                f"Average rate: {known.rate:.3f} Hz",
                f"Most recent transform: {known.newest:.6f} {age}",
                f"Buffer length: {known.newest - known.oldest:.3f} sec",
            )
        )
        lines.append(f'"{parent}" -> "{child}"[label="{label}"];')
    told = f'"Recorded at time: {to_seconds(now):.6f}"[ shape=plaintext ] ;\n ' if now else ""
    legend = ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
    roots = [frame for frame in tree.frames() if frame not in parents]
    lines += [f'edge [style=invis];\n{legend}{told}}}->"{root}";' for root in roots]
    return "\n".join([*lines, "}"])


def _known(tree: FrameTree, frame: str) -> _Known:
    stamps = tree.stamps(frame) or [0]
    rate = len(stamps) * 1e9 / max(stamps[-1] - stamps[0], _SHORTEST_NS)
    return _Known(rate, to_seconds(stamps[-1]), to_seconds(stamps[0]))
