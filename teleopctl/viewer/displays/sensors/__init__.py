"""Displays of sensor data: images, point clouds, laser scans and maps."""
