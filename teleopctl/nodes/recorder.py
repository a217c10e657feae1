"""Executable ``recorder``: writes topics into a bag, for launch files.

Parameters, with rosbag2's names: ``storage.uri`` (folder of the bag), ``storage.storage_id``
(``mcap`` or ``sqlite3``), ``storage.max_bagfile_size``, ``storage.max_bagfile_duration`` (s),
``storage.max_cache_size``, ``record.all_topics`` (default: true if neither topics nor a regex are
given), ``record.topics``, ``record.regex``, ``record.exclude_topics``, ``record.exclude_regex``,
``record.include_hidden_topics``, ``record.start_paused``. Only in teleopctl:
``record.from_first_message``, which records nodes that start later from their first message on.
"""

from __future__ import annotations

import contextlib
import signal
import sys
from pathlib import Path
from typing import Any

from teleopctl.bag import (
    Recorder,
    RecorderOptions,
    Selection,
    WriterOptions,
    database_settings,
    default_bag_folder,
)
from teleopctl.base import progress
from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, known_types
from teleopctl.node import Context, SignalHandlerOptions, parse_ros_arguments

_KINDS: dict[str, type | tuple[type, ...]] = {
    "record.all_topics": bool,
    "record.exclude_regex": str,
    "record.exclude_topics": list,
    "record.from_first_message": bool,
    "record.include_hidden_topics": bool,
    "record.regex": str,
    "record.start_paused": bool,
    "record.topics": list,
    "storage.max_bagfile_duration": int,
    "storage.max_bagfile_size": int,
    "storage.max_cache_size": int,
    "storage.storage_id": str,
    "storage.uri": str,
}
_EVERY_NODE_HAS = ("use_sim_time", "start_type_description_service")


def main(args: list[str] | None = None) -> int:
    """Record topics, chosen by parameters, into a bag until Ctrl-C or SIGTERM; return the status.

    Raises:
        InvalidParameterError: A parameter is unknown, or has the wrong type.
        RefusedError: The bag's path exists already.
        SystemFailureError: The bag cannot be written; the part written before can be read.
    """
    progress.report(progress.STARTING)
    arguments = parse_ros_arguments(sys.argv if args is None else args)
    name = arguments.node_name(RecorderOptions.node_name) or RecorderOptions.node_name
    values = arguments.parameter_overrides(name, arguments.namespace(name) or "/")
    options = _options(values, name)
    folder = Path(values["storage.uri"]) if values.get("storage.uri") else default_bag_folder()
    context = Context()
    # This function handles the signals itself, to finish the bag on SIGINT and SIGTERM.
    context.init(args, signal_handler_options=SignalHandlerOptions.NO)
    with contextlib.suppress(KeyboardInterrupt):
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        recorder = Recorder(folder, options, context=context)
        try:
            progress.report(progress.READY)
            with contextlib.suppress(KeyboardInterrupt):
                recorder.wait()
        finally:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
            recorder.close()
            context.try_shutdown()
    return 0


# Any: parameter values as in YAML.
def _options(values: dict[str, Any], name: str) -> RecorderOptions:
    for key, value in values.items():
        if key in _EVERY_NODE_HAS or key.startswith("qos_overrides."):
            continue
        kind = _KINDS.get(key)
        if kind is None:
            raise InvalidParameterError(
                f"The recorder has no parameter '{key}'",
                hint=f"It has {', '.join(_KINDS)}; `teleopctl bag record` has more.",
            )
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise InvalidParameterError(f"Parameter '{key}' is {value!r}, of the wrong type")

    def value_of(key: str, default: Any) -> Any:
        return values.get(key, default)

    topics, regex = value_of("record.topics", []), value_of("record.regex", "")
    selection = Selection(
        all_topics=value_of("record.all_topics", not topics and not regex),
        topics=topics,
        regex=regex,
        exclude_topics=value_of("record.exclude_topics", []),
        exclude_regex=value_of("record.exclude_regex", ""),
        include_hidden_topics=value_of("record.include_hidden_topics", False),
    )
    duration_s = value_of("storage.max_bagfile_duration", 0)
    form = value_of("storage.storage_id", "") or "mcap"
    if form not in ("mcap", "sqlite3"):
        raise InvalidParameterError(
            f"Parameter 'storage.storage_id' is '{form}', and not mcap or sqlite3"
        )
    return RecorderOptions(
        selection=selection,
        writer=WriterOptions(
            database_settings=database_settings() if form == "sqlite3" else None,
            split_bytes=value_of("storage.max_bagfile_size", 0),
            split_duration_ns=duration_s * NANOSECONDS_PER_SECOND,
            distribution=known_types().distribution,
        ),
        recording_metadata=form == "mcap",
        cache_bytes=value_of("storage.max_cache_size", RecorderOptions.cache_bytes),
        start_paused=value_of("record.start_paused", False),
        use_sim_time=bool(value_of("use_sim_time", False)),
        from_first_message=value_of("record.from_first_message", False),
        node_name=name,
    )
