"""Request to launch a file: arguments and options, saved as JSON for a background process."""

from __future__ import annotations

import json
from pathlib import Path

from teleopctl.base.files import write_private
from teleopctl.launch.model.records import asdict, dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchRequest:
    """A launch file to launch, with its arguments and options.

    Attributes:
        file: Absolute path of the launch file.
        arguments: Launch arguments by name.
        show_all_output: Whether stdout of every process is shown on the screen.
        prefix: Words before the command line of every process, or None.
        prefix_filter: Regular expression for the programs that get the prefix, which has to match
            the whole path or its part after a slash; None for all programs.
        skip_missing: Whether to skip actions whose packages, programs or files are not found.
        debug: Whether to log all events of the launch.
        exit_status: Whether the exit status reports processes that died and Ctrl-C, unlike that of
            ``ros2 launch``.
        watch: Whether to restart processes whose source files are saved.
        record_into: Folder of a bag to record the launch into, or None.
        log_name: Name of the file in the log folder with all output, without its ending.
        ros_arguments: Further words after ``--ros-args`` for nodes, by name of the executable;
            words under an empty name are for all nodes.
        required: Names of executables whose end shuts the launch down.
    """

    file: str
    arguments: dict[str, str] = field(default_factory=dict)
    show_all_output: bool = False
    prefix: str | None = None
    prefix_filter: str | None = None
    skip_missing: bool = False
    debug: bool = False
    exit_status: bool = False
    watch: bool = False
    record_into: str | None = None
    log_name: str = "launch"
    ros_arguments: dict[str, list[str]] = field(default_factory=dict)
    required: list[str] = field(default_factory=list)

    def save(self, path: Path) -> None:
        """Write the request as JSON to a file.

        Raises:
            OSError: The file cannot be written.
        """
        write_private(path, json.dumps(asdict(self), ensure_ascii=False))


def load_request(path: Path) -> LaunchRequest:
    """Return the launch request that `LaunchRequest.save` wrote to a file."""
    return LaunchRequest(**json.loads(path.read_text(encoding="utf-8")))
