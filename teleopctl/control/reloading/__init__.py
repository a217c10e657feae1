"""Exchange of a running controller for one of changed code."""
