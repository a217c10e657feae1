"""Ending the process that a node is in."""

from __future__ import annotations

import contextlib
import os
import signal

import psutil

from teleopctl.cli.verbs.top.processes import NodeRow
from teleopctl.launch import folder_of, mark_stopped, stop_running


def what_stops(row: NodeRow) -> str:
    """Return a description of what ends with the process of a row."""
    if row.running is None:
        return f"{row.name} (process {row.pid}, not started in the background)"
    return f"{row.name} ({row.running.qualified_name}, process {row.pid})"


def stop_process(row: NodeRow) -> None:
    """Stop the process of a row: as ``teleopctl stop``, or by SIGINT.

    Waits until it has ended, where it was started in the background.
    """
    if row.running is not None:
        if row.running.launch is not None:
            mark_stopped(folder_of(row.running.launch), row.running.record.name)
        stop_running(row.running.record)
    elif row.pid is not None:
        number = signal.SIGTERM if os.name == "nt" else signal.SIGINT
        with contextlib.suppress(psutil.Error):
            psutil.Process(row.pid).send_signal(number)
