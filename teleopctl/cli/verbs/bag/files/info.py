"""``teleopctl bag info``."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath, Storage

if TYPE_CHECKING:
    from teleopctl.bag import Bag


def bag_info(
    bag_path: BagPath,
    topic_name: Annotated[
        bool, Option("-t", "--topic-name", help="Print only the names of the topics.")
    ] = False,
    verbose: Annotated[
        bool,
        Option(
            "-v",
            "--verbose",
            help="Read the whole bag, and show how large each topic is and what services did.",
        ),
    ] = False,
    sort: Annotated[
        str,
        Option("--sort", help="What topics are sorted by.", choices=("name", "type", "count")),
    ] = "name",
    storage: Storage = None,
    as_json: AsJson = False,
) -> None:
    """Show what a bag holds: its files, times, topics and services."""
    from teleopctl.bag import open_bag
    from teleopctl.cli.verbs.bag.files.info_text import BagSummary, as_document, as_text

    if topic_name and verbose:
        console.warn(
            "You have set both the '-t' and '-v' parameters. The '-t' parameter will be ignored."
        )
    with open_bag(Path(bag_path), storage) as bag:
        for remark in bag.remarks:
            console.warn(remark)
        summary = BagSummary(bag.metadata, _size(bag), sort)
        if verbose:
            summary.count_all(bag.messages())
        if as_json:
            console.out_json(as_document(summary))
        elif topic_name and not verbose:
            console.out_lines(topic.name for topic, _ in summary.topics)
        else:
            console.out_text(as_text(summary))


def _size(bag: "Bag") -> int:
    if bag.path.is_file():
        return bag.path.stat().st_size
    return sum(file.stat().st_size for file in bag.path.iterdir() if file.is_file())
