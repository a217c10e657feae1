"""Frames of a tree as text for tf2's tools: sentences, YAML and Graphviz."""

from typing import NamedTuple

from teleopctl.interfaces import to_seconds
from teleopctl.tf.tree import FrameTree

# Shortest time span over which tf2 computes the rate of a frame.
_SHORTEST_NS = 100_000
_NOBODY = "default_authority"


class KnownFrame(NamedTuple):
    """Frame that has a parent: its broadcaster, rate in Hz, and newest and oldest stamp in s.

    ``broadcaster`` is empty if it is unknown.
    """

    parent: str
    name: str
    broadcaster: str
    rate: float
    newest_s: float
    oldest_s: float
    is_static: bool


def known_frames(tree: FrameTree) -> list[KnownFrame]:
    """Return a `KnownFrame` for each frame that has a parent, in order of first transforms."""
    return [_known(tree, child, parent) for child, parent in tree.parents()]


def as_string(tree: FrameTree) -> str:
    """Return a text: a line ``Frame A exists with parent B.`` for each frame with a parent."""
    return "".join(
        f"Frame {child} exists with parent {parent}.\n" for child, parent in tree.parents()
    )


def as_yaml(tree: FrameTree) -> str:
    """Return the frames that have a parent, with their statistics, as YAML text; ``[]`` if none."""
    lines = [
        f"{known.name}: \n  parent: '{known.parent}'\n"
        f"  broadcaster: '{known.broadcaster or _NOBODY}'\n"
        f"  rate: {known.rate:.3f}\n"
        f"  most_recent_transform: {known.newest_s:.6f}\n"
        f"  oldest_transform: {known.oldest_s:.6f}\n"
        f"  buffer_length: {known.newest_s - known.oldest_s:.3f}\n"
        f"  is_static: {str(known.is_static).lower()}\n"
        for known in known_frames(tree)
    ]
    return "".join(lines) or "[]"


def as_dot(tree: FrameTree, now: int = 0) -> str:
    """Return the frames as the text of a Graphviz graph, with their ages if ``now`` is not 0.

    Args:
        tree: Tree of the frames.
        now: Time relative to which ages are computed, in nanoseconds; 0 to leave out the ages.
    """
    frames = known_frames(tree)
    lines = ["digraph G {"]
    if not tree.frames():
        lines.append('"no tf data recieved"')  # tf2's spelling
    for known in frames:
        age = f"( {to_seconds(now) - known.newest_s:.3f} sec old)" if now else ""
        label = "".join(
            f"{line}\\n"
            for line in (
                f"Broadcaster: {_escaped(known.broadcaster or _NOBODY)}",
                f"Average rate: {known.rate:.3f} Hz",
                f"Most recent transform: {known.newest_s:.6f} {age}",
                f"Buffer length: {known.newest_s - known.oldest_s:.3f} sec",
            )
        )
        ends = f'"{_escaped(known.parent)}" -> "{_escaped(known.name)}"'
        lines.append(f'{ends}[label="{label}"];')
    time_label = f'"Recorded at time: {to_seconds(now):.6f}"[ shape=plaintext ] ;\n ' if now else ""
    legend = ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
    children = {known.name for known in frames}
    roots = [_escaped(frame) for frame in tree.frames() if frame not in children]
    lines += [f'edge [style=invis];\n{legend}{time_label}}}->"{root}";' for root in roots]
    return "\n".join([*lines, "}"])


def _escaped(name: str) -> str:
    """Return a name escaped for a quoted string of dot."""
    return name.replace("\\", "\\\\").replace('"', '\\"')


def _known(tree: FrameTree, frame: str, parent: str) -> KnownFrame:
    stamps = tree.stamps(frame) or [0]
    rate = len(stamps) * 1e9 / max(stamps[-1] - stamps[0], _SHORTEST_NS)
    _, is_static = tree.newest_stamp(frame) or (0, True)
    return KnownFrame(
        parent,
        frame,
        tree.authority(frame),
        rate,
        to_seconds(stamps[-1]),
        to_seconds(stamps[0]),
        is_static,
    )
