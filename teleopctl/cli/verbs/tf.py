"""``teleopctl tf``: transforms between frames."""

import contextlib

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import from_seconds, get_message, split
from teleopctl.tf import (
    ECHO_DIGITS,
    GATHER_S,
    TF_STATIC_TOPIC,
    TF_TOPIC,
    Buffer,
    MonitorResults,
    Transform,
    TransformListener,
    echo_text,
    echo_transforms,
    monitor_transforms,
    rpy_from_quaternion,
)

if TYPE_CHECKING:
    import threading


GROUP = VerbGroup(
    "Watch transforms between frames.",
    {
        "echo": Verb(f"{__name__}:echo_transform", "Print the transform between two frames."),
        "list": Verb(f"{__name__}:list_frames", "List the frames."),
        "monitor": Verb(
            f"{__name__}:monitor", "Print the delay of transforms and their broadcasters."
        ),
        "static": Verb(
            f"{__name__}:publish_static",
            "Publish a static transform.",
            negative_numbers=True,
            examples=("teleopctl tf static --z 0.5 --frame-id world --child-frame-id table",),
        ),
        "view_frames": Verb(
            f"{__name__}:view",
            "Draw the tree of frames.",
            examples=("teleopctl tf view_frames -o frames",),
        ),
    },
)


_MOST_DIGITS = 17  # digits of a double


def echo_transform(
    source_frame: Annotated[
        str,
        Argument(
            help="Frame in which the transform is expressed.", metavar="SOURCE", complete="frames"
        ),
    ],
    target_frame: Annotated[
        str, Argument(help="Frame whose pose is printed.", metavar="TARGET", complete="frames")
    ],
    rate: Annotated[float, Argument(help="How often to print, in Hz; as -r.")] = 1.0,
    rate_option: Annotated[
        float | None, Option("-r", "--rate", help="How often to print, in Hz.", metavar="HZ")
    ] = None,
    at: Annotated[
        float | None,
        Option(
            "-t",
            "--time",
            help="ROS time of the transform; by default the newest.",
            metavar="SECONDS",
        ),
    ] = None,
    precision: Annotated[
        int, Option("-p", "--precision", help="Number of decimals.", metavar="DIGITS")
    ] = ECHO_DIGITS,
    once: Annotated[bool, Option("--once", help="Print the first transform and end.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a line.")] = False,
) -> None:
    """Print the transform from one frame to another at a rate."""
    if rate_option is not None:
        rate = rate_option
    if not 0.0 < rate < float("inf"):
        raise UsageError(f"The rate must be positive, got {rate:g}")
    if not 0 <= precision <= _MOST_DIGITS:
        raise UsageError(f"The precision is 0 to {_MOST_DIGITS} digits, not {precision}")

    def show(stamp: int, transform: Transform) -> None:
        if as_json:
            console.out_json(
                _transform_document(source_frame, target_frame, stamp, transform), compact=True
            )
        else:
            console.out_text(echo_text(stamp, transform, precision))
        console.flush()

    # Ctrl-C is the normal end of a stream.
    with contextlib.suppress(KeyboardInterrupt), command_node() as node:
        echo_transforms(
            node,
            source_frame,
            target_frame,
            period_s=1.0 / rate,
            once=once,
            stamp=from_seconds(at or 0.0),
            show=show,
            fail=console.note,
            wait=console.note,
        )


def _transform_document(source: str, target: str, stamp: int, transform: Transform) -> console.Json:
    """Return a ``geometry_msgs/msg/TransformStamped`` as JSON, with added roll, pitch and yaw."""
    seconds, nanoseconds = split(stamp)
    return {
        "header": {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": source},
        "child_frame_id": target,
        "transform": {
            "translation": dict(zip("xyz", transform.translation, strict=True)),
            "rotation": dict(zip("xyzw", transform.rotation, strict=True)),
        },
        "rpy": list(rpy_from_quaternion(transform.rotation)),
    }


# Default time to listen, in seconds; robots publish their moving frames more often.
_WAIT_S = 1.0


def list_frames(
    show_parents: Annotated[
        bool, Option("-p", "--show-parents", help="Show the parent of each frame.")
    ] = False,
    count_frames: Annotated[
        bool, Option("-c", "--count-frames", help="Print only the number.")
    ] = False,
    wait_time: Annotated[
        float, Option("-t", "--wait-time", help="Seconds to listen.", metavar="SECONDS")
    ] = _WAIT_S,
    as_json: AsJson = False,
) -> None:
    """Print the names of the frames received on /tf and /tf_static within a time.

    Lists the frames that are broadcast while the command listens, and static frames.
    """
    import time

    if not 0.0 < wait_time < float("inf"):
        raise UsageError(f"The time to listen must be positive, got {wait_time:g}")
    buffer = Buffer()
    with command_node() as node:
        TransformListener(buffer, node)
        time.sleep(wait_time)
    known = {frame.name: frame for frame in buffer.known_frames()}
    names = sorted(buffer.frame_names())
    if as_json:
        console.out_json(
            [
                {
                    "name": name,
                    "parent": known[name].parent if name in known else None,
                    "is_static": known[name].is_static if name in known else None,
                }
                for name in names
            ]
        )
    elif count_frames:
        console.out(str(len(names)))
    elif show_parents:
        console.out_lines(
            f"{name} [{known[name].parent}]" if name in known else name for name in names
        )
    else:
        console.out_lines(names)


def monitor(
    source_frame: Annotated[
        str | None,
        Argument(
            help="Source frame; none for all frames.",
            complete="frames",
            metavar="SOURCE",
        ),
    ] = None,
    target_frame: Annotated[
        str | None,
        Argument(help="Frame whose pose is printed.", complete="frames", metavar="TARGET"),
    ] = None,
    wait_time: Annotated[
        float,
        Option("-t", "--wait-time", help="Seconds to gather data first.", metavar="SECONDS"),
    ] = GATHER_S,
    once: Annotated[bool, Option("--once", help="Print the first results and end.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a line.")] = False,
) -> None:
    """Print the delays of transforms, and their broadcasters.

    Prints each second, after the time to gather data. A delay is the time from a transform's stamp
    to its arrival, in seconds. Ends on Ctrl-C.
    """
    if source_frame is not None and target_frame is None:
        raise UsageError("Give two frames, or none for all frames")
    if not 0.0 < wait_time < float("inf"):
        raise UsageError(f"The time to gather data must be positive, got {wait_time:g}")

    def show(results: MonitorResults) -> None:
        if as_json:
            console.out_json(_results_document(results), compact=True)
        else:
            console.out_text(results.text())
        console.flush()

    # Ctrl-C is the normal end of a stream.
    with contextlib.suppress(KeyboardInterrupt), command_node() as node:
        monitor_transforms(
            node,
            (source_frame, target_frame) if source_frame and target_frame else None,
            gather_s=wait_time,
            once=once,
            show=show,
            say=console.note,
            wait=console.note,
        )


def _results_document(results: MonitorResults) -> console.Json:
    return {
        "chain": results.chain,
        "net_delay": results.net and results.net._asdict(),
        "frames": [
            {
                "name": each.name,
                "publisher": each.publisher,
                "delay": each.delay and each.delay._asdict(),
            }
            for each in results.frames
        ],
        "broadcasters": [
            {
                "node": each.node,
                "rate_hz": each.rate_hz,
                "delay": each.delay and each.delay._asdict(),
            }
            for each in results.broadcasters
        ],
    }


def _number(flag: str, text: str) -> Option:
    return Option(flag, help=text, metavar="NUMBER")


def publish_static(
    words: Annotated[
        list[str] | None,
        Argument(help="ROS 2's older form.", metavar="[X Y Z YAW PITCH ROLL PARENT CHILD]"),
    ] = None,
    frame_id: Annotated[
        str | None,
        Option("--frame-id", help="The parent frame.", metavar="FRAME", complete="frames"),
    ] = None,
    child_frame_id: Annotated[
        str | None, Option("--child-frame-id", help="Child frame.", metavar="FRAME")
    ] = None,
    x: Annotated[float | None, _number("--x", "Position in metres.")] = None,
    y: Annotated[float | None, _number("--y", "Position in metres.")] = None,
    z: Annotated[float | None, _number("--z", "Position in metres.")] = None,
    roll: Annotated[float | None, _number("--roll", "Angle in radians.")] = None,
    pitch: Annotated[float | None, _number("--pitch", "Angle in radians.")] = None,
    yaw: Annotated[float | None, _number("--yaw", "Angle in radians.")] = None,
    qx: Annotated[float | None, _number("--qx", "Quaternion, in place of the angles.")] = None,
    qy: Annotated[float | None, _number("--qy", "Quaternion, in place of the angles.")] = None,
    qz: Annotated[float | None, _number("--qz", "Quaternion, in place of the angles.")] = None,
    qw: Annotated[float | None, _number("--qw", "Quaternion, in place of the angles.")] = None,
) -> int:
    """Publish a static transform until Ctrl-C.

    Same as `run tf2_ros static_transform_publisher`. Ends on Ctrl-C.
    """
    from teleopctl.nodes.execute import run_executable
    from teleopctl.wire import ensure_router

    given = {
        "--frame-id": frame_id,
        "--child-frame-id": child_frame_id,
        "--x": x,
        "--y": y,
        "--z": z,
        "--roll": roll,
        "--pitch": pitch,
        "--yaw": yaw,
        "--qx": qx,
        "--qy": qy,
        "--qz": qz,
        "--qw": qw,
    }
    arguments = [f"{flag}={value}" for flag, value in given.items() if value is not None]
    ensure_router()
    return run_executable(
        "tf2_ros", "static_transform_publisher", [*(words or ()), *arguments], builtin=True
    )


def view(
    wait_time: Annotated[
        float, Option("-t", "--wait-time", help="Seconds to listen.", metavar="SECONDS")
    ] = 5.0,
    output: Annotated[
        str | None,
        Option("-o", "--output", help="File name without extension.", metavar="FILE"),
    ] = None,
    tf_topic: Annotated[str, Option("--tf_topic", help="Topic of dynamic transforms.")] = "/tf",
    tf_static_topic: Annotated[
        str, Option("--tf_static_topic", help="Topic of static transforms.")
    ] = "/tf_static",
    as_json: AsJson = False,
) -> None:
    """Write the tree of frames received within a time as DOT, SVG and, with Graphviz, PDF files.

    Writes a Graphviz file, an SVG, and a PDF if Graphviz's program dot is installed.
    """
    from teleopctl.cli.listing import out_files
    from teleopctl.nodes.tf2.view_frames import view_frames

    with command_node() as node:
        files = view_frames(
            node,
            output,
            console.note,
            wait_s=wait_time,
            tf_topic=tf_topic,
            tf_static_topic=tf_static_topic,
        )
    out_files(files, as_json=as_json)


# Longest wait for completion candidates, in seconds; robots publish transforms more often.
_LONGEST_WAIT_S = 0.4


def _received_frames() -> set[str]:
    """Return the frames of the first received transforms.

    Raises:
        RouterNotRunning: No router runs.
    """
    import threading

    from teleopctl.node import QoSProfile, qos_profile_latched

    message_class = get_message("tf2_msgs/msg/TFMessage")
    frames: set[str] = set()
    with command_node(session_mode="client") as node:
        heard = {
            topic: threading.Event()
            for topic in (TF_TOPIC, TF_STATIC_TOPIC)
            if node.count_publishers(topic) > 0
        }
        for topic, event in heard.items():

            def take(message: Any, event: "threading.Event" = event) -> None:
                for transform in message.transforms:
                    frames.update((transform.header.frame_id, transform.child_frame_id))
                event.set()

            latched = topic == TF_STATIC_TOPIC
            qos = qos_profile_latched if latched else QoSProfile(depth=10)
            node.create_subscription(message_class, topic, take, qos, immediate=True)
        for event in heard.values():
            event.wait(_LONGEST_WAIT_S)
        return set(frames)


def complete_frames(incomplete: str) -> list[str]:
    """Return completion candidates: frames of the first transforms received within 0.4 s."""
    try:
        return sorted(name for name in _received_frames() if name.startswith(incomplete))
    except TeleopctlError:
        return []
