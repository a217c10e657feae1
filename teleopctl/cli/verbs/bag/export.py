"""``teleopctl bag export``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath
from teleopctl.errors import NotFoundError, UsageError

if TYPE_CHECKING:
    from teleopctl.bag import Bag

_FORMATS = ("csv", "parquet", "mp4", "lerobot")


def export(
    bag_path: BagPath,
    topics: Annotated[
        list[str] | None,
        Option("--topics", help="Export only this topic; repeatable.", metavar="TOPIC"),
    ] = None,
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="Output folder; by default the bag's name with a suffix such as _csv.",
            metavar="FOLDER",
        ),
    ] = None,
    fps: Annotated[
        float | None,
        Option(
            "--fps",
            help="With mp4: a constant rate, of the latest pictures, instead of the real times. "
            "With lerobot: frames per second, 30 by default.",
            metavar="RATE",
        ),
    ] = None,
    state: Annotated[
        str,
        Option(
            "--state", help="With lerobot: the topic of joint states, or a field.", metavar="FIELD"
        ),
    ] = "/joint_states",
    action: Annotated[
        list[str] | None,
        Option(
            "--action",
            help="With lerobot: a topic of the robot's commands, or a field; repeatable; by "
            "default those of all controllers.",
            metavar="FIELD",
        ),
    ] = None,
    camera: Annotated[
        list[str] | None,
        Option(
            "--camera",
            help="With lerobot: a topic of images; repeatable; by default all colour images.",
            metavar="[NAME=]TOPIC",
        ),
    ] = None,
    task: Annotated[
        str, Option("--task", help="With lerobot: description of the task.", metavar="TEXT")
    ] = "teleoperation",
    form: Annotated[str, Option("--format", help="Output format.", choices=_FORMATS)] = "csv",
    as_json: AsJson = False,
) -> None:
    """Export a bag for other programs: tables, videos, or a LeRobot data set.

    A row of a table is a message: times of recording and publication in nanoseconds since 1970,
    then all fields.
    """
    from teleopctl.bag import open_bag

    if fps is not None and form not in ("mp4", "lerobot"):
        raise UsageError("--fps is for --format mp4 and lerobot")
    if (action or camera) and form != "lerobot":
        raise UsageError("--action and --camera are for --format lerobot")
    if topics and form == "lerobot":
        raise UsageError("Topics of --format lerobot are those of --state, --action and --camera")
    path = Path(bag_path)
    folder = Path(output) if output else Path(f"{path.resolve().stem}_{form}")
    with open_bag(path) as bag:
        for remark in bag.remarks:
            console.warn(remark)
        written = _Written(as_json)
        if form == "lerobot":
            _export_lerobot(bag, folder, state, action, camera, fps, task, written)
        elif form == "mp4":
            _export_films(bag, folder, topics, fps, written)
        else:
            _export_tables(bag, folder, topics, "parquet" if form == "parquet" else "csv", written)
    if as_json:
        console.out_json({"format": form, "written": written.records})


class _Written:
    """List of written files: printed one by one as text, or together at the end as JSON.

    Args:
        as_json: Whether the output is JSON.
    """

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self.records: list[dict[str, console.Json]] = []

    def say(self, text: str, **record: "console.Json") -> None:
        """Record a written file for the JSON output; print its line unless the output is JSON."""
        self.records.append(record)
        if not self._as_json:
            console.out_text(text)


def _export_tables(
    bag: "Bag",
    folder: Path,
    topics: list[str] | None,
    form: Literal["csv", "parquet"],
    written: _Written,
) -> None:
    from teleopctl.bag import TableExport

    tables = TableExport(bag, folder, topics, form)
    for topic, reason in tables.left_out.items():
        console.warn(f"{topic} is left out. {reason}")
    for file in tables.write():
        written.say(
            f"{file.path}: messages {file.rows}, columns {file.columns}",
            path=str(file.path),
            topic=file.topic,
            messages=file.rows,
            columns=file.columns,
        )
        if file.unreadable:
            console.warn(f"{file.topic}: {file.unreadable} not readable. {file.reason}")
    if not written.records:
        raise NotFoundError(f"{bag.path} has no topic that makes a table")


def _export_films(
    bag: "Bag", folder: Path, topics: list[str] | None, rate: float | None, written: _Written
) -> None:
    from teleopctl.bag import VideoExport

    for film in VideoExport(bag, folder, topics, rate).write():
        width, height = film.size
        written.say(
            f"{film.path}: frames {film.frames}, {width} x {height}, {film.duration_s:.1f} s",
            path=str(film.path),
            topic=film.topic,
            frames=film.frames,
            width=width,
            height=height,
            duration_s=film.duration_s,
        )
        if film.left_out:
            console.warn(f"{film.topic}: {film.left_out} not shown. {film.reason}")
    if not written.records:
        raise NotFoundError(f"{bag.path} has no topic with pictures")


def _export_lerobot(
    bag: "Bag",
    folder: Path,
    state: str,
    action: list[str] | None,
    cameras: list[str] | None,
    fps: float | None,
    task: str,
    written: _Written,
) -> None:
    from teleopctl.bag import (
        LeRobotOptions,
        export_lerobot,
        find_actions,
        find_cameras,
        find_hand,
    )

    if fps is not None and not fps.is_integer():
        raise UsageError(f"LeRobot's rates are whole numbers, not {fps:g}")
    if action is None:
        action = find_actions(bag)
    if cameras is None:
        cameras = [f"{name}={topic}" for name, topic in find_cameras(bag).items()]
    hand = find_hand(bag)
    options = LeRobotOptions(state, action, cameras, int(fps or 30), task, hand=hand)
    summary = export_lerobot(bag, folder, options)
    lines = [f"{folder}: frames {summary.frames} at {options.fps} Hz, one episode"]
    lines += [f"  {key}: {', '.join(names)}" for key, names in summary.names.items()]
    lines += [f"  {camera}" for camera in summary.cameras]
    times = "stamps" if summary.by_stamps else "times of recording"
    worst = f" ({summary.worst_feature})" if summary.worst_feature else ""
    age_ms = summary.worst_offset_s * 1e3
    lines += [f"  values by their {times}, at most {age_ms:.0f} ms old{worst}"]
    written.say(
        "\n".join(lines),
        path=str(folder),
        frames=summary.frames,
        fps=options.fps,
        names={key: list(names) for key, names in summary.names.items()},
        cameras=list(summary.cameras),
        worst_offset_s=summary.worst_offset_s,
    )
    for topic, count in summary.left_out.items():
        console.warn(f"{topic}: {count} messages left out")
