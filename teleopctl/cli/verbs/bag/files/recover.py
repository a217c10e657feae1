"""``teleopctl bag recover``."""

from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath


def recover_bag(
    bag_path: BagPath,
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="A folder for what can be read; the bag itself is left as it is then.",
            metavar="FOLDER",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Recover a bag whose recorder was killed, or that a disk has damaged.

    What is only cut off gets its end in place. What is broken otherwise is left as it is, and what
    can be read of it goes into a new bag, by default BAG_recovered. The exit status is 1 where
    something is lost.
    """
    from teleopctl.bag import recover
    from teleopctl.cli.verbs.bag.files.writing import progress

    with progress() as told:
        recovery = recover(Path(bag_path), Path(output) if output else None, told)
    if as_json:
        console.out_json(
            {
                "path": str(recovery.path),
                "messages": recovery.message_count,
                "done": recovery.done,
                "damage": recovery.damage,
                "lost": recovery.lost,
            }
        )
    else:
        console.out_lines(recovery.damage)
        console.out_lines(recovery.done or [f"{recovery.path} is whole"])
        console.out_lines(f"Lost: {sentence}" for sentence in recovery.lost)
        console.out(f"{recovery.path} has {recovery.message_count} messages")
    return 1 if recovery.lost else 0
