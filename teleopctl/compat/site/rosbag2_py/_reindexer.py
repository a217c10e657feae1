"""``rosbag2_py._reindexer``. New metadata for bags."""

from pathlib import Path

from rosbag2_py._storage import StorageOptions, errors_of_rosbag2
from teleopctl import bag

__all__ = ["Reindexer"]


class Reindexer:
    """Writer of a new ``metadata.yaml`` for the files of a bag."""

    def reindex(self, storage_options: StorageOptions) -> None:
        """Write ``metadata.yaml`` again from the files of a bag.

        Raises:
            RuntimeError: The folder has no files of a bag, or one is damaged.
        """
        with errors_of_rosbag2():
            bag.reindex(Path(storage_options.uri))
