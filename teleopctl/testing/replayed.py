"""Recorded sessions as regression tests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.nodes.bag_verification.verification import Verification

# Lines of each list of differences in the error message.
_MOST_LINES = 20


def assert_bag_repeats(path: Path | str, *, tolerance: float = 0.0) -> Verification:
    """Simulate a recorded bag again; raise AssertionError if messages differ, else return results.

    Args:
        path: Folder or file of the bag, recorded from the start of the simulation.
        tolerance: Largest allowed difference of two numbers (rad, rad/s, N m; m, m/s, N); 0
            requires the same bits, which another version of MuJoCo may not compute.

    Returns:
        Result of the comparison: messages, library versions and remarks.

    Raises:
        AssertionError: A message differs; the error has the first and the largest differences.
        TeleopctlError: The bag has no complete run, or its robot cannot be simulated.
    """
    from teleopctl.nodes.bag_verification.verification import verify_bag

    found = verify_bag(Path(path), tolerance=tolerance)
    verdict = found.verdict
    if not verdict.is_same:
        lines = [f"{path}: {verdict.messages} messages compared, first differences:"]
        lines += [f"  {difference}" for difference in verdict.first_differences[:_MOST_LINES]]
        lines.append("largest differences:")
        lines += [f"  {difference}" for difference in verdict.largest_differences[:_MOST_LINES]]
        lines += [
            f"recorded with {name} {then}, and {now} is here"
            for name, (then, now) in found.other_versions.items()
        ]
        lines += found.remarks
        raise AssertionError("\n".join(lines))
    return found
