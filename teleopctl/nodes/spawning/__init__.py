"""Programs that load, activate and take away controllers."""
