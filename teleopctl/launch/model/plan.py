"""What a launch is going to do: processes with everything decided.

A plan is plain data, so that it can be printed, or handed to a supervisor in another process.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessPlan:
    """One process to start.

    Attributes:
        name: Name in the output, ``exec-N``.
        command: Program and arguments; one text for a shell when ``shell`` is set.
        environment: Variables that differ from the launch's own; None removes one.
        working_directory: Folder to start in, or None for the current one.
        shell: Whether a shell reads the command.
        show_stdout: Whether stdout appears on the screen; stderr always does.
        is_node: Whether it is a ROS node, that is whether it becomes visible in the graph.
        node_name: Full name of the node where the launch file gives it, or None.
        ends_by_itself: Whether it does its work and ends, as a spawner does.
        accompanies: Whether it is there from before the others start, once it says that it is
            ready, until after they have ended, as a recorder is.
        start_delay: Seconds from the start of the launch to its own.
        respawn: Whether to start it again when it ends.
        respawn_delay: Seconds to wait before that.
        respawn_max_retries: How often, -1 for any number of times.
        shutdown_on_exit: Whether its end ends the launch.
        sigterm_timeout: Seconds from SIGINT to SIGTERM.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL.
    """

    name: str
    command: list[str]
    environment: dict[str, str | None] = field(default_factory=dict)
    working_directory: str | None = None
    shell: bool = False
    show_stdout: bool = False
    is_node: bool = False
    node_name: str | None = None
    ends_by_itself: bool = False
    accompanies: bool = False
    start_delay: float = 0.0
    respawn: bool = False
    respawn_delay: float = 0.0
    respawn_max_retries: int = -1
    shutdown_on_exit: bool = False
    sigterm_timeout: float = 5.0
    sigkill_timeout: float = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchPlan:
    """Everything that a launch does.

    Attributes:
        log_directory: Folder for logs and parameter files; it need not exist yet.
        processes: What to start, in order.
        messages: Lines of ``log`` actions, as level and text.
        warnings: What the evaluation found odd.
        files: Parameter files to write before the start, as path and content.
    """

    log_directory: Path
    processes: list[ProcessPlan]
    messages: list[tuple[str, str]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)

    def write_files(self) -> None:
        """Create the log folder and the parameter files."""
        self.log_directory.mkdir(parents=True, exist_ok=True)
        for path, content in self.files.items():
            Path(path).write_text(content, encoding="utf-8")

    def dump(self) -> str:
        """Return the plan as JSON."""
        document = {
            "log_directory": str(self.log_directory),
            "processes": [asdict(process) for process in self.processes],
            "messages": self.messages,
            "warnings": self.warnings,
        }
        return json.dumps(document, ensure_ascii=False, indent=1)


def load_plan(text: str) -> LaunchPlan:
    """Read a plan from JSON; its parameter files were written by who made the plan."""
    document = json.loads(text)
    return LaunchPlan(
        log_directory=Path(document["log_directory"]),
        processes=[ProcessPlan(**process) for process in document["processes"]],
        messages=[(level, message) for level, message in document["messages"]],
        warnings=document["warnings"],
    )
