"""``teleopctl drive``: drives a simulated robot from a page in the browser."""

import os
import signal
import socket
import sys
import time
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import LaunchError, NotFoundError, UsageError

if TYPE_CHECKING:
    from teleopctl.base.background import ProcessRecord
    from teleopctl.base.token_file import Address
    from teleopctl.launch import ProcessStatus

VERB = Verb(
    f"{__name__}:drive",
    "Drive a robot by hand: mouse, keys, gamepad, or a phone's touch pads.",
    examples=(
        "teleopctl drive",
        "teleopctl drive my_robot.urdf.xacro",
        "teleopctl drive --lan",
        "teleopctl drive --device gamepad",
        'teleopctl drive --record cube --task "Put the cube into the bin"',
    ),
)

_PAGE = "drive"
_LONGEST_START_S = 3600.0
_PERIOD_S = 0.3
_ANSWER_S = 1.0
# Nothing is sent to this address: connecting only looks up our own in the routing table.
_ELSEWHERE = ("192.0.2.1", 9)


def drive(
    words: Annotated[
        list[str] | None,
        Argument(
            metavar="[ROBOT] [NAME:=VALUE]...",
            help="URDF, xacro, SDF or MJCF of the robot, by default the teleop arm with a cube and "
            "a bin; arguments of drive.yaml and of the robot's xacro.",
            complete="files",
        ),
    ] = None,
    lan: Annotated[
        bool,
        Option("--lan", help="Open the page to the local network, with a token: for a phone."),
    ] = False,
    port: Annotated[
        int | None,
        Option("--port", help="Port of the page; by default 8080, or the next free one."),
    ] = None,
    open_page: Annotated[
        bool, Option("--open", help="Open the page in the browser, which a desktop does by itself.")
    ] = False,
    no_open: Annotated[bool, Option("--no-open", help="Do not open the page.")] = False,
    record: Annotated[
        str | None,
        Option(
            "--record",
            help="Record episodes by buttons of the page, for a data set in this folder.",
            metavar="FOLDER",
        ),
    ] = None,
    task: Annotated[
        str | None,
        Option("--task", help="With --record: what the robot does, in words.", metavar="TEXT"),
    ] = None,
    device: Annotated[
        str | None,
        Option(
            "--device",
            help="Drive by this device, too, whose state is shown here.",
            metavar="NAME",
            complete="teleop_devices",
        ),
    ] = None,
    mapping: Annotated[
        str | None,
        Option(
            "--mapping",
            help="With --device: what its axes and buttons do, a YAML file.",
            metavar="FILE",
            complete="files",
        ),
    ] = None,
    leader: Annotated[
        str | None,
        Option(
            "--leader",
            help="Follow another arm of the graph, of this namespace.",
            metavar="NAMESPACE",
        ),
    ] = None,
    devices: Annotated[
        bool, Option("--devices", help="List the devices, and start nothing.")
    ] = False,
    who: Annotated[bool, Option("--who", help="Print who drives now, and start nothing.")] = False,
    release: Annotated[
        bool,
        Option("--release", help="End the lease of the node that drives now, and start nothing."),
    ] = False,
    detach: Annotated[bool, Option("--detach", "-d", help="Return once everything is up.")] = False,
) -> int:
    """Start a robot, its controllers, servo and the drive page; Ctrl-C ends them."""
    from teleopctl.base.start_timeouts import StartTimeouts
    from teleopctl.compat import activation
    from teleopctl.launch import (
        LaunchRequest,
        addresses,
        find_launch_file,
        start_in_background,
        stop_running,
    )

    if devices:
        return _list_devices()
    if who or release:
        if words or lan or who is release:
            raise UsageError("--who and --release stand alone")
        return _lease(ends=release)
    if open_page and no_open:
        raise UsageError("--open and --no-open exclude each other")
    arguments = _arguments(words or [])
    # The command needs the page, also on a machine without a display.
    arguments = {"viewer": "true", **arguments, "page_port": "" if port is None else str(port)}
    if task is not None and record is None:
        raise UsageError("--task is for --record")
    if record is not None:
        recording = {"episodes": record, "task": task or "", "camera": "true"}
        arguments = {name: value for name, value in recording.items() if value} | arguments
    chosen = _device(device, mapping, leader)
    if chosen and detach:
        raise UsageError(
            "--device shows its state in this terminal, and --detach gives that back",
            hint=f"Start it by itself: teleopctl run teleop_device teleop_device "
            f"{chosen['device']}",
        )
    if lan:
        arguments["page_host"] = "0.0.0.0"  # noqa: S104 -- by an option, with a token
    activation.activate_children()
    request = LaunchRequest(
        file=str(find_launch_file(None, "drive.yaml")), arguments=arguments, show_all_output=True
    )
    running: list[ProcessStatus] = []

    def on_up(process: "ProcessStatus", node: str | None) -> None:
        del node
        if process.state == "running":
            running.append(process)

    # The first start of a robot may cut its meshes for minutes, which is shown.
    timeouts = StartTimeouts(total_s=_LONGEST_START_S)
    started = start_in_background(
        request, "drive", on_up, console.warn, timeouts, console.note, ends_on_failure=True
    )
    keeps = False
    try:
        found = addresses(running)
        if not found and not chosen:
            raise LaunchError(
                f"{_why_no_page(running)}; the robot is driven from the page",
                hint=f"All of it has been ended; see `teleopctl logs {started.name}`.",
            )
        if found:
            _print_how(found[0], lan=lan)
            if open_page or (not no_open and _has_desktop()):
                from teleopctl.nodes.rviz2 import open_in_browser

                open_in_browser(_of_page(found[0]))
        if not detach:
            return _drive_by(chosen, started) if chosen else _wait(started)
        console.out(f"To end it: teleopctl stop {started.name}")
        keeps = True
    finally:
        if not keeps:
            stop_running(started)
    return 0


def _why_no_page(running: "list[ProcessStatus]") -> str:
    """Return why a launch has no page, in words."""
    if any(process.name.startswith("rviz2") for process in running):
        return "The page has not printed its address"
    return "The launch starts no page (is it called with viewer:=false?)"


def _list_devices() -> int:
    """Print the teleoperation devices."""
    from teleopctl import plugins

    kind = plugins.TELEOP_DEVICES
    found = plugins.available(kind).values()
    width = max(len(plugin.name) for plugin in found)
    for plugin in found:
        text = kind.summaries.get(plugin.name, "") or f"from {plugin.distribution}"
        console.out(f"{plugin.name:{width}}  {text}")
    return 0


def complete_devices(incomplete: str) -> list[str]:
    """Return the names of devices that begin with a word."""
    from teleopctl import plugins

    names = plugins.available(plugins.TELEOP_DEVICES)
    return [name for name in names if name.startswith(incomplete)]


def _device(device: str | None, mapping: str | None, leader: str | None) -> dict[str, str]:
    """Return the parameters of the device that the options choose; empty for none.

    Raises:
        UsageError: The options contradict each other.
        UnknownPluginError: There is no such device.
        BrokenPluginError: The device cannot be imported.
        DeviceError: The device is not there.
        NotFoundError: There is no such mapping.
        InvalidFileError: The mapping's file cannot be read, or is no mapping.
    """
    if leader is not None:
        device = device or "leader"
    if device is None:
        if mapping is not None:
            raise UsageError("--mapping is for --device")
        return {}
    from teleopctl.nodes.teleop.device_node import check_device

    check_device(device, mapping)
    given = {"device": device, "mapping": mapping, "leader": leader}
    return {name: value for name, value in given.items() if value is not None}


def _drive_by(parameters: dict[str, str], record: "ProcessRecord") -> int:
    """Drive by a device until Ctrl-C; return 1 if the launch ends by itself."""
    from teleopctl.base import background
    from teleopctl.node import Parameter
    from teleopctl.nodes.teleop.device_node import drive as drive_by

    console.note("Ctrl-C ends it.")
    overrides = [Parameter(name, value=value) for name, value in parameters.items()]
    drive_by(overrides, [], lambda: background.is_alive(record))
    return 0 if background.is_alive(record) else _wait(record)


def _lease(*, ends: bool) -> int:
    """Print the node that holds the command lease, or end the lease."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.node import LEASE_TOPIC, LeaseHolder, SingleThreadedExecutor

    with command_node(session_mode="client", name="teleop_lease") as node:
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        holder = LeaseHolder(node, [])
        end_s = time.monotonic() + _ANSWER_S
        # The driving node publishes its claim at 2 Hz; a latched claim arrives at once.
        while holder.watch.holder is None and time.monotonic() < end_s:
            if node.count_publishers(LEASE_TOPIC) <= 1 and time.monotonic() > end_s - _ANSWER_S / 2:
                break
            executor.spin_once(0.05)
        claim = holder.end_any() if ends else holder.watch.holder
    if claim is None:
        console.out("No node drives the robot")
        return 0
    since = time.strftime("%H:%M:%S", time.localtime(claim.since_ns / 1e9))
    console.out(f"{'Ended: ' if ends else ''}{claim} drives since {since}")
    return 0


def _arguments(words: list[str]) -> dict[str, str]:
    """Return the launch arguments of the command's words.

    Raises:
        UsageError: A word is neither a robot nor ``name:=value``.
        NotFoundError: The robot's file does not exist.
    """
    arguments: dict[str, str] = {}
    for word in words:
        name, separator, value = word.partition(":=")
        if separator and name:
            arguments[name] = value
        elif "model" in arguments:
            raise UsageError(f"'{word}' is a second robot; arguments are NAME:=VALUE")
        else:
            if not Path(word).exists() and "://" not in word:
                raise NotFoundError(
                    f"There is no file '{word}'",
                    hint="Name the robot's URDF, xacro, SDF or MJCF file.",
                )
            arguments["model"] = word
    return arguments


def _of_page(address: "Address") -> "Address":
    return address._replace(url=f"{address.url}{_PAGE}")


def _print_how(address: "Address", *, lan: bool) -> None:
    """Print in four lines how the robot is driven."""
    page = _of_page(address)
    console.out(f"Mouse:   {page.with_token}  drag the handle at the gripper")
    console.out("Keys:    on that page, or in a terminal of its own: teleopctl run teleop_keyboard")
    console.out(
        "Gamepad: switch it on and press a button on that page; it moves while its left shoulder "
        "button is held"
    )
    if lan:
        host, token = _own_address(), page.with_token
        shown = token.replace(socket.gethostname(), host, 1) if host else token
        console.out(f"Phone:   {shown}")
    else:
        console.out("Phone:   teleopctl drive --lan prints an address for one in the same network")
    console.flush()


def _own_address() -> str:
    """Return this machine's address in the local network; empty if there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_ELSEWHERE)  # sends nothing
        except OSError:
            return ""
        return str(probe.getsockname()[0])


def _has_desktop() -> bool:
    """Return whether this machine has a desktop on which a browser can open."""
    if not sys.stdout.isatty() or "SSH_CONNECTION" in os.environ:
        return False
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _wait(record: "ProcessRecord") -> int:
    """Wait for Ctrl-C; return 1 if the launch ends by itself."""
    from teleopctl.base import background
    from teleopctl.launch import log_tail

    console.note("Ctrl-C ends it.")
    # A closed terminal and `kill` end it as well.
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.default_int_handler)
    try:
        while background.is_alive(record):
            time.sleep(_PERIOD_S)
    except KeyboardInterrupt:
        return 0
    console.out_text(log_tail(record.log_file))
    console.note("The launch has ended by itself; above is the end of its log.")
    return 1
