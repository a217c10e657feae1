"""``teleopctl bag check``."""

from pathlib import Path

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verbs.bag.options import BagPath


def check_bag(bag_path: BagPath, as_json: AsJson = False) -> int:
    """Check a whole bag and print its faults; the exit status is 1 if there are any.

    Checksums, indexes, metadata.yaml, definitions and their hashes, messages that cannot be
    decoded, messages that are missing, times that go back.
    """
    from teleopctl.bag import check
    from teleopctl.cli.verbs.bag.files.writing import progress

    with progress() as told:
        findings = list(check(Path(bag_path), told))
    if as_json:
        console.out_json([finding._asdict() for finding in findings])
    elif findings:
        console.out_lines(f"{finding.place}: {finding.what}" for finding in findings)
    else:
        console.out(f"{bag_path}: nothing is wrong")
    return 1 if findings else 0
