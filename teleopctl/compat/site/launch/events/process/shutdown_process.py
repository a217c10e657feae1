"""``launch.events.process.shutdown_process``."""

from .process_targeted_event import ShutdownProcess as ShutdownProcess
