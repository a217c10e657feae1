"""``launch.events.process.signal_process``."""

from .process_targeted_event import SignalProcess as SignalProcess
