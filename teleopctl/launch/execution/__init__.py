"""Execution of launch plans: starts, watches, shows and stops the processes."""
