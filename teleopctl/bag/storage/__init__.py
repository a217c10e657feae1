"""Bags as rosbag2 lays them out: a folder of files with ``metadata.yaml``."""
