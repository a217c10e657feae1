"""``teleopctl episode``: recorded episodes, and the data set that is made of them."""

from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.bag import EpisodeFolder, LeRobotSummary

GROUP = VerbGroup(
    "Record and edit episodes for training.",
    {
        "record": Verb(
            f"{__name__}:record",
            "Record episodes by keys or services.",
            examples=(
                'teleopctl episode record cube --task "Put the cube into the bin"',
                "teleopctl episode record cube --task push --episodes 20 --reset --seed 7",
            ),
        ),
        "list": Verb(f"{__name__}:list_episodes", "List episodes."),
        "stats": Verb(f"{__name__}:stats", "Show features, times and statistics of all episodes."),
        "replay": Verb(
            f"{__name__}:replay",
            "Simulate an episode again, and compare it bit by bit.",
            examples=("teleopctl episode replay cube 3",),
        ),
        "view": Verb(f"{__name__}:view", "Show an episode on the page."),
        "trim": Verb(
            f"{__name__}:trim",
            "Cut off the start or the end of an episode.",
            examples=("teleopctl episode trim cube 3 --start 0.5 --end 8",),
        ),
        "drop": Verb(
            f"{__name__}:drop",
            "Remove episodes from the data set.",
            examples=("teleopctl episode drop cube 3 5",),
        ),
        "build": Verb(
            f"{__name__}:build",
            "Add saved episodes that the data set lacks, after a crash for example.",
        ),
    },
)

Folder = Annotated[str, Argument(help="Folder of the episodes.", metavar="FOLDER")]
Number = Annotated[int, Argument(help="Number of the episode, from 0.", metavar="NUMBER")]


def record(
    folder: Folder,
    task: Annotated[str, Option("--task", help="What the robot does, in words.", metavar="TEXT")],
    episodes: Annotated[
        int, Option("--episodes", help="Number of episodes to save; 0 for no limit.", metavar="N")
    ] = 0,
    fps: Annotated[int, Option("--fps", help="Frames per second.", metavar="RATE")] = 30,
    robot: Annotated[
        str, Option("--robot", help="Type of the robot in one word.", metavar="NAME")
    ] = "",
    camera: Annotated[
        list[str] | None,
        Option(
            "--camera",
            help="A topic of images; repeatable; by default all colour images.",
            metavar="[NAME=]TOPIC",
            repeated=True,
        ),
    ] = None,
    action: Annotated[
        list[str] | None,
        Option(
            "--action",
            help="A topic of the robot's commands, or a field; repeatable; by default those of all "
            "controllers.",
            metavar="FIELD",
            repeated=True,
        ),
    ] = None,
    state: Annotated[
        str, Option("--state", help="The topic of joint states, or a field.", metavar="FIELD")
    ] = "/joint_states",
    episode_time: Annotated[
        float, Option("--episode-time", help="Seconds after which an episode is saved; 0 for none.")
    ] = 0.0,
    reset: Annotated[
        bool,
        Option("--reset", help="Begin each episode with a reset of the simulation."),
    ] = False,
    seed: Annotated[
        int, Option("--seed", help="With --reset: seed of the places of the objects.")
    ] = 0,
    use_sim_time: Annotated[
        bool, Option("--use-sim-time", help="Use simulated time, from /clock.")
    ] = False,
) -> int:
    """Record episodes of what somebody or a program does with the robot.

    Keys of the terminal, or the services ~/start, ~/save, ~/discard and ~/success of
    /episode_recorder, begin and end an episode. Each is a bag in FOLDER/episodes, and each saved
    one is added to the LeRobot data set in FOLDER.
    """
    from teleopctl.node import Parameter
    from teleopctl.nodes.episodes.recorder import record as record_episodes

    values: dict[str, bool | int | float | str | list[str]] = {
        "folder": folder,
        "task": task,
        "episodes": episodes,
        "fps": fps,
        "robot": robot,
        "cameras": camera or [""],
        "action": action or [""],
        "state": state,
        "episode_time": episode_time,
        "reset": reset,
        "seed": seed,
        "use_sim_time": use_sim_time,
    }
    parameters = [Parameter(name, value=value) for name, value in values.items()]
    return record_episodes(args=[], parameters=parameters, shows_keys=True)


def list_episodes(folder: Folder, as_json: AsJson = False) -> None:
    """List the episodes of a data set: length, task, success, and who drove the robot."""
    found = _existing(folder)
    fps = found.dataset.fps or 0
    rows = found.rows()
    if as_json:
        console.out_json(
            [
                {
                    "episode": row.number,
                    "frames": row.length,
                    "seconds": row.length / fps,
                    "task": row.task,
                    "success": row.notes.success,
                    "driven_by": row.notes.driven_by,
                    "worst_offset_s": row.notes.worst_offset_s,
                    "bag": str(bag) if (bag := found.bag(row.number)).exists() else None,
                }
                for row in rows
            ]
        )
        return
    for row in rows:
        words = [f"{row.number:4}  {row.length / fps:6.1f} s  {row.length:6} frames"]
        if row.notes.success is not None:
            words.append("success" if row.notes.success else "failure")
        if row.notes.driven_by:
            words.append(f"by {row.notes.driven_by}")
        console.out("  ".join([*words, row.task]))
    if missing := found.missing():
        numbers = ", ".join(map(str, missing))
        console.warn(
            f"Not in the data set yet: {numbers}. Add them: teleopctl episode build {folder}"
        )
    for left in found.unfinished():
        console.warn(f"An episode that was not saved is in {left}")


def stats(folder: Folder, as_json: AsJson = False) -> None:
    """Show the features of a data set, with range and mean of each element over all episodes."""
    found = _existing(folder)
    rows, data = found.rows(), found.dataset
    fps = data.fps or 1
    frames = sum(row.length for row in rows)
    successes = sum(row.notes.success is True for row in rows)
    worst_s = max((row.notes.worst_offset_s for row in rows), default=0.0)
    if as_json:
        console.out_json(
            {
                "episodes": len(rows),
                "frames": frames,
                "fps": fps,
                "successes": successes,
                "worst_offset_s": worst_s,
                "features": data.features,
                "statistics": data.statistics,
            }
        )
        return
    console.out(f"{len(rows)} episodes, {frames} frames at {fps} Hz, {frames / fps:.1f} s")
    console.out(f"{successes} successes; values at most {worst_s * 1e3:.0f} ms old")
    statistics = data.statistics
    for key, feature in data.features.items():
        if feature["dtype"] == "video":
            height, width, _ = feature["shape"]
            console.out(f"{key}: video, {width} x {height}")
            continue
        console.out(f"{key}:")
        units = (feature.get("info") or {}).get("units") or [""] * len(feature["names"])
        values = statistics[key]
        for place, (name, unit) in enumerate(zip(feature["names"], units, strict=True)):
            low, high, mean = (values[each][place] for each in ("min", "max", "mean"))
            console.out(f"  {name}: {low:.4g} to {high:.4g} {unit}, mean {mean:.4g}".rstrip())


def replay(folder: Folder, number: Number, as_json: AsJson = False) -> int:
    """Simulate an episode again from its first state, and compare all messages.

    As `bag verify`: in its own process, without a graph, as fast as the machine allows.
    """
    from teleopctl.cli.verbs.bag.verify import verify

    bag = _existing(folder).existing_bag(number)
    return verify(str(bag), as_json=as_json)


def view(folder: Folder, number: Number) -> None:
    """Show an episode on the page, with robot, pictures, plots and a time line."""
    from teleopctl.cli.verbs.bag.view import view as view_bag

    view_bag(str(_existing(folder).existing_bag(number)))


def trim(
    folder: Folder,
    number: Number,
    start: Annotated[
        float | None,
        Option("--start", help="Seconds from the start of the bag that are cut off.", metavar="S"),
    ] = None,
    end: Annotated[
        float | None,
        Option("--end", help="Time in seconds at which the episode ends.", metavar="S"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Cut off the start or the end of an episode, in the data set and in its bag.

    A simulated episode gets the state at its new start, from which it is replayed. The whole bag
    is put into FOLDER/episodes/dropped.
    """
    if start is None and end is None:
        raise UsageError("Nothing to cut off: name --start or --end")
    from teleopctl.nodes.bag_verification.verification import state_since

    summary = _existing(folder).trim(number, start, end, state_since)
    console.out_done(
        f"Episode {number} has {summary.frames} frames now",
        as_json=as_json,
        episode=number,
        frames=summary.frames,
    )


def drop(
    folder: Folder,
    numbers: Annotated[
        list[str], Argument(help="Numbers of the episodes, from 0.", metavar="NUMBER...")
    ],
    as_json: AsJson = False,
) -> None:
    """Remove episodes from the data set; later ones get their numbers.

    The bags are put into FOLDER/episodes/dropped.
    """
    if wrong := [text for text in numbers if not text.isdecimal()]:
        raise UsageError(
            f"'{wrong[0]}' is not the number of an episode",
            hint=f"`teleopctl episode list {folder}` shows them.",
        )
    found = _existing(folder)
    moved = found.drop([int(text) for text in numbers])
    for bag in moved:
        console.note(f"{bag} has the bag")
    left = len(found.rows())
    console.out_done(f"{left} episodes are left", as_json=as_json, episodes=left)


def build(folder: Folder, as_json: AsJson = False) -> int:
    """Add the saved episodes that the data set lacks; the exit status is 1 if one is rejected."""
    found = _existing(folder)
    added: list[console.Json] = []

    def say(number: int, summary: "LeRobotSummary") -> None:
        age_ms = summary.worst_offset_s * 1e3
        worst = f" ({summary.worst_feature})" if summary.worst_feature else ""
        added.append({"episode": number, "frames": summary.frames})
        if not as_json:
            ages = f"values at most {age_ms:.0f} ms old{worst}"
            console.out(f"Episode {number}: {summary.frames} frames, {ages}")
        for topic, count in summary.left_out.items():
            console.warn(f"Episode {number}: {count} messages of {topic} left out")
        for feature, silent_s in summary.silent_s.items():
            console.warn(
                f"Episode {number}: {feature} was silent for {silent_s:.1f} s; to remove the "
                f"episode: teleopctl episode drop {folder} {number}"
            )

    rejected = found.add_missing(say)
    if as_json:
        console.out_json({"added": added, "rejected": list(rejected)})
    for sentence in rejected:
        console.warn(sentence)
    return 1 if rejected else 0


def _existing(folder: str) -> "EpisodeFolder":
    from teleopctl.bag import EpisodeFolder

    return EpisodeFolder.existing(Path(folder))
