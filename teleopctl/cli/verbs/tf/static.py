"""``teleopctl tf static``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option


def _number(flag: str, text: str) -> Option:
    return Option(flag, help=text, metavar="NUMBER")


def publish(
    words: Annotated[
        list[str] | None,
        Argument(help="ROS 2's older form.", metavar="[X Y Z YAW PITCH ROLL PARENT CHILD]"),
    ] = None,
    frame_id: Annotated[
        str | None,
        Option("--frame-id", help="The parent frame.", metavar="FRAME", complete="frames"),
    ] = None,
    child_frame_id: Annotated[
        str | None, Option("--child-frame-id", help="The frame that stands in it.", metavar="FRAME")
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
    """Publish where a frame stands once and for all.

    The same as `run tf2_ros static_transform_publisher`. Ctrl-C ends it.
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
