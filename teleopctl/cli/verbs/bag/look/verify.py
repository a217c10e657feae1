"""``teleopctl bag verify``."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath

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
    as_json: AsJson = False,
) -> int:
    """Simulate a recorded session once more, and compare every state with the recording."""
    from teleopctl.nodes.verifying import verify_bag

    found = verify_bag(Path(bag_path), tolerance=tolerance, world=world)
    for remark in found.remarks:
        console.warn(remark)
    if as_json:
        console.out_json(_document(found))
    else:
        console.out_lines(_lines(found))
    return _SAME if found.verdict.is_same else _OTHER


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
