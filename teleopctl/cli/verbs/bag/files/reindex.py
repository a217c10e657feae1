"""``teleopctl bag reindex``."""

from pathlib import Path

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verbs.bag.options import BagPath, Storage
from teleopctl.errors import NotFoundError


def reindex_bag(bag_path: BagPath, storage: Storage = None, as_json: AsJson = False) -> None:
    """Rebuild metadata.yaml from the files of a bag.

    Files that were not finished get their end.
    """
    from teleopctl.bag import reindex

    del storage  # the names of the files tell
    if not Path(bag_path).is_dir():
        raise NotFoundError("Must specify a bag directory")
    console.note(f"Beginning reindexing bag in directory: {bag_path}")
    metadata = reindex(Path(bag_path))
    console.note(f"Reindexing complete: {metadata.message_count} messages.")
    if as_json:
        console.out_json({"bags": [{"folder": bag_path, "messages": metadata.message_count}]})
