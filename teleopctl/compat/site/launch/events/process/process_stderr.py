"""``launch.events.process.process_stderr``."""

from .process_io import ProcessStderr as ProcessStderr
