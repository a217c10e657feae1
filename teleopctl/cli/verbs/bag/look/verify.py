"""``teleopctl bag verify``."""

import os
from collections.abc import Iterator
from pathlib import Path

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath
from teleopctl.typed import TYPE_CHECKING, Annotated

if TYPE_CHECKING:
    from teleopctl.nodes.verifying import Verification

_SAME, _OTHER = 0, 1


def verify(
    bag_path: BagPath,
    tolerance: Annotated[
        float,
        Option("--tolerance", help="What two numbers may be apart; 0 asks for the same bits."),
    ] = 0.0,
    world: Annotated[
        str | None, Option("--world", help="Another world than the recorded one.", metavar="FILE")
    ] = None,
    picture: Annotated[
        str | None,
        Option(
            "-o", "--output", help="Draw what differs first: a .png, .svg or .pdf.", metavar="FILE"
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Simulate a recorded session once more, and compare every state with the recording."""
    # It draws nothing: what MUJOCO_GL asks for, and what it lacks, concerns the camera alone.
    # mujoco reads that when it is imported.
    os.environ["MUJOCO_GL"] = "disable"
    from teleopctl.bag import Traces, check_picture_name
    from teleopctl.nodes.verifying import verify_bag

    traces = Traces()
    if picture is None:
        found = verify_bag(Path(bag_path), tolerance=tolerance, world=world)
    else:
        check_picture_name(Path(picture))
        found = verify_bag(Path(bag_path), tolerance=tolerance, world=world, on_state=traces.note)
    for remark in found.remarks:
        console.warn(remark)
    if as_json:
        console.out_json(_document(found))
    else:
        console.out_lines(_lines(found))
    if found.verdict.is_same:
        return _SAME
    if picture is not None:
        from teleopctl.bag import save_picture

        first = found.verdict.first[0]
        save_picture(traces.curves(first), Path(picture), Path(bag_path).resolve().name)
        console.note(f"{picture}: {first.joint} {first.field}")
    return _OTHER


def _lines(found: "Verification") -> Iterator[str]:
    from teleopctl.interfaces import to_seconds

    verdict = found.verdict
    how = "the same bits" if not verdict.tolerance else f"within {verdict.tolerance:g}"
    told = f"{verdict.states} states compared, up to {to_seconds(verdict.end_ns):.3f} s"
    if verdict.is_same:
        yield f"{told}: {how}."
    else:
        yield f"{told}: not {how}."
        yield "First difference:"
        yield from (f"  {difference}" for difference in verdict.first)
        yield "Largest differences:"
        yield from (f"  {difference}" for difference in verdict.largest.values())
    for name, (then, now) in found.other_versions.items():
        yield f"Recorded with {name} {then}, and {now} is here."


def _document(found: "Verification") -> console.Json:
    verdict = found.verdict
    return {
        "same": verdict.is_same,
        "states": verdict.states,
        "tolerance": verdict.tolerance,
        "first": [difference._asdict() for difference in verdict.first],
        "largest": [difference._asdict() for difference in verdict.largest.values()],
        "other_versions": {
            name: {"recorded": then, "here": now}
            for name, (then, now) in found.other_versions.items()
        },
    }
