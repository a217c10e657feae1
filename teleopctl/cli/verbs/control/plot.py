"""``teleopctl control plot``: reference, feedback and error of a trajectory controller."""

import contextlib
import math
import shutil
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from teleopctl.base.extras import extra
from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson, PictureFile
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.manager import ControllerName, ManagerOptions, command_line
from teleopctl.errors import (
    NotFoundError,
    UnavailableError,
    UsageError,
    existing_names_hint,
)
from teleopctl.interfaces import get_message, to_nanoseconds

if TYPE_CHECKING:
    from teleopctl.bag import Curve
    from teleopctl.control import ControllerManagerClient

_TYPE = "control_msgs/msg/JointTrajectoryControllerState"
_PARTS = ("reference", "feedback", "error")
_WIDTH, _HEIGHT = 80, 16
_NS_PER_S = 1e9
# Longest wait for the first state, in seconds.
_FIRST_WITHIN_S = 1.0
# Decimals that are drawn: further ones are rounding errors.
_DECIMALS = 9


def plot(
    controller: ControllerName,
    joints: Annotated[
        str | None,
        Option("--joints", help="Joints, with commas between them; all by default.", metavar="J"),
    ] = None,
    field: Annotated[
        str,
        Option(
            "--field", help="What to draw.", choices=("positions", "velocities", "accelerations")
        ),
    ] = "positions",
    window: Annotated[
        float, Option("--window", help="Seconds to record, on the controller's clock.", metavar="S")
    ] = 5.0,
    output: PictureFile = None,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Draw reference, feedback and error of a trajectory controller over a window of time.

    Start it, then send the trajectory. The largest error and the root mean square of the errors
    follow the drawing.
    """
    if not 0.0 < window < math.inf:
        raise UsageError(f"--window must be more than 0 s, not {window:g}")
    if output is not None:
        from teleopctl.bag import check_plot_file

        check_plot_file(Path(output))
    elif not as_json:
        with extra("tui", "uniplot"):
            import uniplot as uniplot
    chosen = [name.strip() for name in joints.split(",")] if joints else []
    with manager.client() as client:
        tracking = Tracking(field, window)
        _record(client, controller, chosen, tracking, window)
    wanted = chosen or list(tracking.joints)
    if as_json:
        console.out_json([tracking.document(joint) for joint in wanted])
        return
    if output is not None:
        from teleopctl.bag import save_panels

        save_panels(tracking.panels(wanted), Path(output), f"{controller}: {field}", columns=2)
    else:
        console.out_drawing("\n".join(_drawing(tracking, wanted)))
    console.out_lines(tracking.summary(wanted))


class Tracking:
    """Reference, feedback and error of the joints of a trajectory controller over time.

    Args:
        field: Field of the points: ``positions``, ``velocities`` or ``accelerations``.
        window_s: Length of the recording, in seconds.

    Attributes:
        joints: Names of the joints, from the first message.
        is_complete: Whether the window is over.
    """

    def __init__(self, field: str, window_s: float) -> None:
        self.joints: Sequence[str] = ()
        self.is_complete = False
        self._field = field
        self._window_ns = round(window_s * _NS_PER_S)
        self._times_ns: list[int] = []
        # For each part, the values of all joints by time.
        self._values: dict[str, list[list[float]]] = {part: [] for part in _PARTS}

    # Any: a message, whose class is generated at run time.
    def add(self, message: Any) -> None:
        """Add a JointTrajectoryControllerState message, unless the window is over."""
        now_ns = to_nanoseconds(message.header.stamp)
        if self._times_ns and now_ns < self._times_ns[-1]:  # a simulation was reset
            self._times_ns.clear()
            for values in self._values.values():
                values.clear()
        if self._times_ns and now_ns - self._times_ns[0] > self._window_ns:
            self.is_complete = True
            return
        self.joints = list(message.joint_names)
        self._times_ns.append(now_ns)
        for part, values in self._values.items():
            given = list(getattr(getattr(message, part), self._field))
            values.append(given or [math.nan] * len(self.joints))

    def __len__(self) -> int:
        return len(self._times_ns)

    def times(self) -> list[float]:
        """Return the times of the samples, in seconds since the first one."""
        return [(time_ns - self._times_ns[0]) / _NS_PER_S for time_ns in self._times_ns]

    def values(self, part: str, joint: str) -> list[float]:
        """Return reference, feedback or error of a joint over time."""
        index = self.joints.index(joint)
        return [values[index] for values in self._values[part]]

    def curves(self, joint: str, *parts: str) -> "list[Curve]":
        """Return curves of a joint, named by their parts."""
        from teleopctl.bag import Curve

        times = self.times()
        return [Curve(part, times, self.values(part, joint)) for part in parts]

    def panels(self, joints: Sequence[str]) -> "Mapping[str, Sequence[Curve]]":
        """Return two panels for each joint: reference with feedback, and the error."""
        panels: dict[str, list[Curve]] = {}
        for joint in joints:
            panels[joint] = self.curves(joint, "reference", "feedback")
            panels[f"{joint}: error"] = self.curves(joint, "error")
        return panels

    def summary(self, joints: Sequence[str]) -> Iterator[str]:
        """Yield a line with the largest and the root mean square error of each joint."""
        width = max(map(len, joints), default=0)
        for joint in joints:
            largest, when_s, rms = self._errors(joint)
            if largest is None:
                yield f"{joint:{width}}  no {self._field}"
            else:
                when = f"at {when_s:.2f} s"
                yield f"{joint:{width}}  largest error {largest:.4g} {when}, rms {rms:.4g}"

    def _errors(self, joint: str) -> tuple[float | None, float, float]:
        """Return the error of the largest magnitude, its time, and the root mean square."""
        pairs = zip(self.times(), self.values("error", joint), strict=True)
        errors = [(time_s, error) for time_s, error in pairs if math.isfinite(error)]
        if not errors:
            return None, 0.0, 0.0
        when_s, largest = max(errors, key=lambda pair: abs(pair[1]))
        return largest, when_s, math.sqrt(sum(error**2 for _, error in errors) / len(errors))

    def document(self, joint: str) -> dict[str, Any]:
        """Return a joint's curves and errors for JSON; values that are not finite are None."""
        largest, _, rms = self._errors(joint)
        curves = {
            part: [x if math.isfinite(x) else None for x in self.values(part, joint)]
            for part in _PARTS
        }
        rms_error = None if largest is None else rms
        return {
            "joint": joint,
            "largest_error": largest,
            "rms_error": rms_error,
            "times": self.times(),
            **curves,
        }


def _record(
    client: "ControllerManagerClient",
    controller: str,
    joints: Sequence[str],
    tracking: Tracking,
    window_s: float,
) -> None:
    """Record a controller's states for a window of its time, or until Ctrl-C.

    Args:
        client: Client of the controller manager.
        controller: Name of the controller.
        joints: Joints that it must have.
        tracking: Recording, to which the states are added.
        window_s: Length of the window, in seconds.

    Raises:
        NotFoundError: The controller does not exist, is none of trajectories, or lacks a joint.
        UnavailableError: The controller is not active, or sends no states.
    """
    found = {one.name: one for one in client.list_controllers()}
    if controller not in found:
        raise NotFoundError(
            f"controller {controller} does not seem to be loaded",
            hint=existing_names_hint("controllers", [controller], found),
        )
    node, one = client.node, found[controller]
    topic = f"{client.name.rpartition('/')[0]}/{controller}/controller_state"
    if not node.graph().publishers(topic, _TYPE):
        raise NotFoundError(
            f"Controller '{controller}' ({one.type}, {one.state}) publishes no {_TYPE} on {topic}",
            hint="Trajectory controllers do, once they are configured; `teleopctl topic echo TOPIC "
            "--plot FIELD` draws other topics.",
        )
    if one.state != "active":
        raise UnavailableError(
            f"Controller '{controller}' is {one.state}: only an active controller has a reference",
            hint=f"`{command_line(client.name, 'doctor', controller)}` says how to activate it.",
        )
    changed = threading.Condition()

    def take(message: Any) -> None:
        with changed:
            tracking.add(message)
            changed.notify_all()

    node.create_subscription(get_message(_TYPE), topic, take, 100, immediate=True)
    console.note(f"Recording {topic} for {window_s:g} s; Ctrl-C ends it earlier")
    with changed:
        is_sent = changed.wait_for(lambda: len(tracking) > 0, max(window_s, _FIRST_WITHIN_S))
    if not is_sent:
        raise UnavailableError(
            f"No message on {topic}",
            hint=f"`{command_line(client.name, 'doctor', controller)}` says why.",
        )
    if unknown := [name for name in joints if name not in tracking.joints]:
        raise NotFoundError(
            f"Controller '{controller}' has no joint {', '.join(unknown)}",
            hint=existing_names_hint("joints", unknown, tracking.joints),
        )
    _wait(changed, tracking, window_s)


def _wait(changed: threading.Condition, tracking: Tracking, window_s: float) -> None:
    """Wait until the window is over, no message comes for its length, or Ctrl-C."""
    with contextlib.suppress(KeyboardInterrupt), changed:
        before = -1
        while not tracking.is_complete and len(tracking) != before:
            before = len(tracking)
            changed.wait_for(lambda: tracking.is_complete, window_s)


def _drawing(tracking: Tracking, joints: Sequence[str]) -> Iterator[str]:
    """Yield text plots with their titles: of each joint, then of all errors."""
    from teleopctl.base.printable import printable_line
    from teleopctl.cli.verbs.topic.plot import MOST_TRACES

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else _WIDTH
    for joint in joints:
        yield f"{printable_line(joint)}:"
        yield _text_plot(tracking.curves(joint, "reference", "feedback"), width)
    errors = [
        tracking.curves(joint, "error")[0]._replace(name=printable_line(joint)) for joint in joints
    ]
    if not any(round(value, _DECIMALS) for curve in errors for value in curve.values):
        yield f"No error (reference - feedback) above {10**-_DECIMALS:g}"
        return
    yield "Errors (reference - feedback):"
    yield _text_plot(errors[:MOST_TRACES], width)


def _text_plot(curves: "Sequence[Curve]", width: int) -> str:
    from teleopctl.cli.verbs.topic.plot import line_plot_text, reduced_points

    last_s = max(curves[0].times[-1], 1e-3)
    lines = []
    for curve in curves:
        values = [round(value, _DECIMALS) for value in curve.values]
        points = list(zip(curve.times, values, strict=True))
        lines.append((curve.name, *reduced_points(points, 0.0, last_s, width)))
    colour = sys.stdout.isatty() and console.colour_enabled(sys.stdout)
    text = line_plot_text(lines, (0.0, last_s), width, _HEIGHT, colour=colour)
    return text or "None of the values is a number"
