"""``teleopctl bag export``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from teleopctl.bag import Bag, EpisodeNotes, LeRobotOptions

_FORMATS = ("csv", "parquet", "mp4", "lerobot")


def export(
    bag_paths: Annotated[
        list[str],
        Argument(
            help="The bag: its folder, or one of its files; with lerobot several, or folders of "
            "episodes.",
            metavar="BAG...",
            complete="bags",
        ),
    ],
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
        str | None,
        Option(
            "--state",
            help="With lerobot: the topic of joint states, or a field; by default /joint_states.",
            metavar="FIELD",
        ),
    ] = None,
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
        str | None,
        Option(
            "--task",
            help="With lerobot: description of the task; by default that of the episode.",
            metavar="TEXT",
        ),
    ] = None,
    success_only: Annotated[
        bool,
        Option("--success-only", help="With lerobot: leave out episodes that are no success."),
    ] = False,
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
    if form != "lerobot" and (state or action or camera or task or success_only):
        raise UsageError(
            "--state, --action, --camera, --task and --success-only are for --format lerobot"
        )
    if len(bag_paths) > 1 and form != "lerobot":
        raise UsageError(
            "Only --format lerobot takes several bags", hint="`teleopctl bag merge` makes them one."
        )
    if topics and form == "lerobot":
        raise UsageError("Topics of --format lerobot are those of --state, --action and --camera")
    path = Path(bag_paths[0])
    folder = Path(output) if output else Path(f"{path.resolve().stem}_{form}")
    written = _Written(as_json)
    if form == "lerobot":
        if fps is not None and not fps.is_integer():
            raise UsageError(f"LeRobot's rates are whole numbers, not {fps:g}")
        rate = None if fps is None else int(fps)
        given = {"state": state, "action": action, "cameras": camera, "fps": rate, "task": task}
        settings = {name: value for name, value in given.items() if value is not None}
        _export_lerobot(bag_paths, folder, settings, written, successes=success_only)
    else:
        with open_bag(path) as bag:
            for remark in bag.remarks:
                console.warn(remark)
            if form == "mp4":
                _export_films(bag, folder, topics, fps, written)
            else:
                _export_tables(
                    bag, folder, topics, "parquet" if form == "parquet" else "csv", written
                )
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


# Any: values of the settings of an episode.
def _export_lerobot(
    paths: list[str],
    folder: Path,
    settings: dict[str, Any],
    written: _Written,
    *,
    successes: bool,
) -> None:
    from teleopctl.bag import (
        EPISODE_RECORD,
        EpisodeNotes,
        EpisodeSettings,
        episode_bags,
        export_lerobot,
        find_hand,
        open_bag,
    )

    rates: set[int] = set()
    left_out = 0

    def bags() -> "Iterator[Bag]":
        nonlocal left_out
        for path in paths:
            for each in episode_bags(Path(path)):
                with open_bag(each) as bag:
                    for remark in bag.remarks:
                        console.warn(remark)
                    if successes and not EpisodeSettings.of(bag).success:
                        left_out += 1
                    else:
                        yield bag
        if left_out and not rates:
            raise NotFoundError(
                f"No episode is a success; left out: {left_out}",
                hint="Without --success-only, all are exported.",
            )

    def options(bag: "Bag") -> "tuple[LeRobotOptions, EpisodeNotes]":
        of_bag = EpisodeSettings.of(bag)._replace(**settings)
        found = of_bag.options(bag)
        # Episodes have the operator's twists even if there are none; another bag, those in it.
        if EPISODE_RECORD not in dict(bag.records()):
            found = found._replace(hand=find_hand(bag))
        rates.add(found.fps)
        return found, EpisodeNotes(of_bag.success, of_bag.driven_by)

    summaries = export_lerobot(bags(), folder, options)
    count, frames = len(summaries), sum(summary.frames for summary in summaries)
    first, worst = summaries[0], max(summaries, key=lambda summary: summary.worst_offset_s)
    rate = rates.pop()
    episodes = "one episode" if count == 1 else f"{count} episodes"
    lines = [f"{folder}: frames {frames} at {rate} Hz, {episodes}"]
    lines += [f"  {key}: {', '.join(names)}" for key, names in first.names.items()]
    lines += [f"  {camera}" for camera in first.cameras]
    times = "stamps" if first.by_stamps else "times of recording"
    of_feature = f" ({worst.worst_feature})" if worst.worst_feature else ""
    age_ms = worst.worst_offset_s * 1e3
    lines += [f"  values by their {times}, at most {age_ms:.0f} ms old{of_feature}"]
    written.say(
        "\n".join(lines),
        path=str(folder),
        episodes=count,
        frames=frames,
        fps=rate,
        names={key: list(names) for key, names in first.names.items()},
        cameras=list(first.cameras),
        worst_offset_s=worst.worst_offset_s,
    )
    if left_out:
        console.note(f"Episodes without success, left out: {left_out}")
    for summary in summaries:
        for topic, unusable in summary.left_out.items():
            console.warn(f"{topic}: {unusable} messages left out")
