"""``launch.events.process.process_stdin``."""

from .process_io import ProcessStdin as ProcessStdin
