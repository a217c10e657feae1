"""Execution of launch plans: processes are started, watched, shown and stopped."""
