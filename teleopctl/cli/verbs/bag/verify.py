"""``teleopctl bag verify``."""

import os
from collections.abc import Iterator
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath

if TYPE_CHECKING:
    from teleopctl.bag import ComparedTraces
    from teleopctl.nodes.bag_verification.verification import Verification

_SAME, _OTHER = 0, 1


def verify(
    bag_path: BagPath,
    tolerance: Annotated[
        float,
        Option("--tolerance", help="Allowed difference of two numbers; 0 requires equal bits."),
    ] = 0.0,
    world: Annotated[
        str | None, Option("--world", help="Another world than the recorded one.", metavar="FILE")
    ] = None,
    picture: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="Plot of the first difference: a .png, .svg or .pdf.",
            metavar="FILE",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Simulate a recorded session again and compare the messages; return 0 if all match, else 1."""
    # The simulation renders nothing, so MUJOCO_GL and its errors concern the camera node only.
    # mujoco reads the variable at import.
    os.environ["MUJOCO_GL"] = "disable"
    from teleopctl.bag import ComparedTraces, check_plot_file
    from teleopctl.nodes.bag_verification.verification import verify_bag

    traces = ComparedTraces()
    if picture is None:
        found = verify_bag(Path(bag_path), tolerance=tolerance, world=world)
    else:
        check_plot_file(Path(picture))
        found = verify_bag(Path(bag_path), tolerance=tolerance, world=world, on_message=traces.add)
    for remark in found.remarks:
        console.warn(remark)
    if as_json:
        console.out_json(_document(found))
    else:
        console.out_lines(_lines(found))
    if found.verdict.is_same:
        return _SAME
    if picture is not None:
        _draw(found, traces, Path(picture), Path(bag_path).resolve().name)
    return _OTHER


def _draw(found: "Verification", traces: "ComparedTraces", picture: Path, title: str) -> None:
    from teleopctl.bag import save_plot

    # Missing messages have no field to plot.
    differences = [
        each
        for each in found.verdict.first_differences + found.verdict.largest_differences
        if each.field
    ]
    if not differences:
        console.warn("There is no differing number to plot")
        return
    first = differences[0]
    save_plot(traces.curves(first), picture, title)
    console.note(f"{picture}: {first.topic} {first.field}")


def _lines(found: "Verification") -> Iterator[str]:
    from teleopctl.interfaces import to_seconds

    verdict = found.verdict
    how = "the same bits" if not verdict.tolerance else f"within {verdict.tolerance:g}"
    topics = len({stream.topic for stream in verdict.streams})
    counted = f"{verdict.messages} messages on {topics} topics compared"
    compared = f"{counted}, up to {to_seconds(verdict.end_ns):.3f} s"
    yield f"{compared}: {how}." if verdict.is_same else f"{compared}: not {how}."
    if not verdict.is_same:
        yield "First differences:"
        yield from (f"  {difference}" for difference in verdict.first_differences)
    if largest := verdict.largest_differences:
        yield "Largest differences:"
        yield from (f"  {difference}" for difference in largest)
    yield "Compared:"
    for stream in sorted(verdict.streams, key=lambda each: each.name):
        count = _counted(stream.compared)
        times = f", {to_seconds(stream.begin_ns):.3f} to {to_seconds(stream.end_ns):.3f} s"
        differ = f": {stream.difference_count} differences" if stream.difference_count else ""
        yield f"  {stream.name}: {count}{times if stream.recorded else ''}{differ}"
    if verdict.played_back:
        yield "Played back:"
        yield from (f"  {topic}: {_counted(count)}" for topic, count in verdict.played_back.items())
    reasons: dict[str, list[str]] = {}
    for topic, reason in verdict.not_compared.items():
        reasons.setdefault(reason, []).append(topic)
    if reasons:
        yield "Not compared:"
        yield from (f"  {', '.join(names)}: {reason}" for reason, names in reasons.items())
    for name, (then, now) in found.other_versions.items():
        yield f"Recorded with {name} {then}, and {now} is here."


def _counted(count: int) -> str:
    return f"{count} message{'' if count == 1 else 's'}"


def _document(found: "Verification") -> console.Json:
    verdict = found.verdict
    return {
        "same": verdict.is_same,
        "messages": verdict.messages,
        "tolerance": verdict.tolerance,
        "compared": [
            {
                "topic": stream.topic,
                "publisher": stream.publisher,
                "messages": stream.compared,
                "differences": stream.difference_count,
            }
            for stream in verdict.streams
        ],
        "first": [difference._asdict() for difference in verdict.first_differences],
        "largest": [difference._asdict() for difference in verdict.largest_differences],
        "played_back": dict(verdict.played_back),
        "not_compared": dict(verdict.not_compared),
        "other_versions": {
            name: {"recorded": then, "here": now}
            for name, (then, now) in found.other_versions.items()
        },
    }
