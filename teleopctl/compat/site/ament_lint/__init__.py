"""``ament_lint``. What the linters of ament packages share."""
