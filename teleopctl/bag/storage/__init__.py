"""Storage of bags in rosbag2's layout, a folder of files with ``metadata.yaml``."""
