"""What sensors send: pictures, clouds of points, scans, maps."""
