"""``ament_mypy``. Checks of types by mypy, where it is installed."""
