"""``rosbag2_py._info``. Metadata of bags."""

from pathlib import Path

from rosbag2_py._storage import BagMetadata, errors_of_rosbag2, metadata_of
from teleopctl import bag

__all__ = ["Info"]


class Info:
    """Reader of the metadata of bags, also of those without ``metadata.yaml``."""

    def read_metadata(self, uri: str, storage_id: str = "") -> BagMetadata:
        """Return the metadata of a bag.

        Raises:
            RuntimeError: There is no bag, or it cannot be read.
        """
        with errors_of_rosbag2(), bag.open_bag(uri, storage_id or None) as opened:
            return metadata_of(opened.metadata, Path(uri))
