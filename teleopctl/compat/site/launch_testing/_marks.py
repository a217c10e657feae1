"""Attributes that mark the decorated functions and classes of a test file."""

IS_AFTER_SHUTDOWN = "__post_shutdown_test__"
"""Of a class: its tests run when all processes have ended."""

TIMEOUT = "__ready_to_test_action_timeout__"
"""Of a test description's function: seconds until ``ReadyToTest`` has to be reached."""

IS_PARAMETRIZED = "__parametrized__"
"""Of a function that gives test descriptions, one for each set of values."""

MARKERS = "__markers__"
"""Of a test description's function: what it is marked with, such as ``keep_alive``."""
