"""``launch.events.process.process_stdout``."""

from .process_io import ProcessStdout as ProcessStdout
