"""The viewer: a node whose picture and panels are a page in the browser.

Everything that knows the graph runs on the node's thread: messages arrive there, what users do on
the page is handed over to it, and a timer moves the picture on, thirty times a second while
somebody looks. Nobody looks: the timer stands still, and displays and panels listen to nothing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from teleopctl import plugins
from teleopctl.base.access import is_loopback
from teleopctl.base.token_file import Address, default_token_file, read_or_make_token
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service, known_types
from teleopctl.node import Clock, ClockType, Node, QoSProfile
from teleopctl.tf import NamedTransformListener, Transform
from teleopctl.viewer.page.server import close_server, open_server, page_address
from teleopctl.viewer.page.tidying import EVERY_S, MemoryCleanup
from teleopctl.viewer.panels.base import Panel
from teleopctl.viewer.picture import SceneView
from teleopctl.viewer.robot_file import RobotFile
from teleopctl.viewer.scene.frame_buffer import FrameBuffer
from teleopctl.viewer.scene.frames import SceneFrames
from teleopctl.viewer.unknown_types import UnknownTypes

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.page.page_server import PageServer

_PICTURES_PER_S = 30.0
# Panels are read, not watched: every third picture is enough.
_PICTURES_PER_PANEL_TICK = 3
_COMPLAINS_EVERY_S = 5.0
# A page that is loaded anew, or whose connection broke, is back by then.
_BACK_WITHIN_S = 5.0


class Viewer(Node):
    """The viewer: a node with the page that it serves.

    Args:
        server: The page.
        view: The ``.rviz`` file to begin with.
        panels: The panels by name, in their order; None is all that there are.
        cli_args: The node's own ROS arguments; those of the process count besides.
    """

    def __init__(
        self,
        server: PageServer,
        view: Path | None = None,
        panels: list[str] | None = None,
        cli_args: Sequence[str] | None = None,
    ) -> None:
        super().__init__("rviz", cli_args=cli_args)
        self.node = self
        self.stage = self
        self.server = server
        server.mistakes.log = self.get_logger().warning
        self.scene = server.scene
        self.gui = server.gui
        self._watched = False
        self._pictures = 0
        self._last_time_ns = 0
        self._errands: deque[Callable[[], object]] = deque()
        self._errand = self.create_guard_condition(self._run_errands)
        self._types = UnknownTypes(self, self.work)
        self._workers = ThreadPoolExecutor(2, thread_name_prefix="work")
        self.buffer = FrameBuffer(self)
        self.frames = SceneFrames(server.scene, self.buffer)
        self._listener: NamedTransformListener | None = None
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0 / _PICTURES_PER_S, self._tick, clock=steady)
        self._timer.cancel()
        self._patience = self.create_timer(
            _BACK_WITHIN_S, lambda: self._do(self._end_showing), clock=steady
        )
        self._patience.cancel()
        self.create_timer(EVERY_S, MemoryCleanup(server).tidy, clock=steady)
        simulated = bool(self.get_parameter("use_sim_time").value)
        self.picture = SceneView(server, self, view, simulated=simulated)
        self.robot_file = RobotFile(self)
        self.create_service(get_service("std_srvs/srv/Empty"), "~/reset_time", self._reset_time)
        self.panels = self._make_panels(panels)
        self.add_graph_callback(lambda: self.soon(self._tell_of_graph))
        server.on_client_connect(self.on(lambda _client: self._look()))
        server.on_client_disconnect(self.on(lambda _client: self._look()))
        server.audience.on_change(self.on(self._look))

    def _make_panels(self, names: list[str] | None) -> list[Panel]:
        made: list[Panel] = []
        tabs = self.gui.add_tab_group()
        for name in names or plugins.available(plugins.PANELS):
            kind: type[Panel] = plugins.load(plugins.PANELS, name)
            if not (names or kind.is_default):
                continue
            panel = kind(self)
            with tabs.add_tab(panel.title, cast("viser.IconName", panel.icon)):
                panel.build()
            made.append(panel)
        return made

    # --- what displays and panels use ---------------------------------------------------------

    # Any, here and below: messages of any type, results of any task, and what YAML holds.
    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: QoSProfile
    ) -> Callable[[], None]:
        """Subscribe to a topic; return a function that ends the subscription.

        A type that is not known on this machine is learned first; see `Stage.knows`.
        """

        def begin() -> Callable[[], None]:
            subscription = self.create_subscription(
                get_message(type_name), topic, lambda message: self._do(callback, message), qos
            )

            def end() -> None:
                self.destroy_subscription(subscription)

            return end

        return begin() if self.knows(type_name) else self._types.when_known(type_name, begin)

    def knows(self, type_name: str) -> bool:
        """Return whether a type is known on this machine; see `Stage.knows`."""
        return known_types().find(type_name) is not None

    @property
    def robot_folder(self) -> Path | None:
        """Folder of the robot's description file; None if unknown."""
        path = self.robot_file.path
        return None if path is None else path.parent

    def camera(self) -> Transform | None:
        """Return the camera's pose; see `Stage.camera`."""
        return self.picture.camera()

    def work(self, task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        """Run a long task in another thread; see `Stage.work`."""

        def run() -> None:
            try:
                result = task()
            except Exception as error:  # noqa: BLE001 -- it is whose task it is that decides
                result = error
            self.soon(lambda: then(result))

        self._workers.submit(run)

    def soon(self, errand: Callable[[], object]) -> None:
        """Run a function on the node's thread; may be called on any thread."""
        self._errands.append(errand)
        self._errand.trigger()

    def on(self, function: Callable[..., object]) -> Callable[..., None]:
        """Wrap a function for viser's callbacks, so that it runs on the node's thread."""

        def hand_over(*arguments: Any) -> None:
            self.soon(lambda: function(*arguments))

        return hand_over

    def reset(self) -> None:
        """Clear transforms and displays, as RViz's Reset does."""
        self.buffer.clear()
        self.picture.reset()

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification in all browsers, for some seconds."""
        for client in self.server.get_clients().values():
            client.add_notification(
                title, text, color="red" if wrong else None, auto_close_seconds=8.0
            )

    # --- the picture --------------------------------------------------------------------------

    def _look(self) -> None:
        """Find out whether anybody looks.

        Who is back at once has not been away: plots go on, and nothing is listened to anew. Zenoh
        would keep some memory for each time, in every process (docs/robustness.md, Soak).
        """
        if not any(map(self.server.audience.looks, self.server.get_clients())):
            if self._watched:
                self._patience.reset()
            return
        self._patience.cancel()
        if not self._watched:
            self._begin_showing()

    def _begin_showing(self) -> None:
        self._watched = True
        self._listener = NamedTransformListener(self.buffer, self)
        self.picture.begin()
        for panel in self.panels:
            self._do(panel.began)
        self._timer.reset()

    def _end_showing(self) -> None:
        self._patience.cancel()
        self._watched = False
        self._timer.cancel()
        if self._listener is not None:
            self._listener.unregister()
            self._listener = None
        self.picture.end()
        for panel in self.panels:
            self._do(panel.ended)

    # Any: request and response of RViz's service for its Reset.
    def _reset_time(self, _request: Any, response: Any) -> Any:
        self._do(self.reset)
        return response

    def _tell_of_graph(self) -> None:
        self._types.look()
        for panel in self.panels:
            self._do(panel.graph_changed)

    def _tick(self) -> None:
        self._pictures += 1
        now_ns = self.get_clock().now().nanoseconds
        jumped_back, self._last_time_ns = now_ns < self._last_time_ns, now_ns
        with self.server.atomic():
            self._do(self.frames.update)
            self._do(lambda: self.picture.tick(jumped_back=jumped_back))
        if self._pictures % _PICTURES_PER_PANEL_TICK == 0:
            for panel in self.panels:
                self._do(panel.tick)

    def _run_errands(self) -> None:
        # What is added meanwhile triggers anew, so that messages get their turn.
        for _ in range(len(self._errands)):
            failure = self._do(self._errands.popleft())
            if failure:
                self.notify("That did not work", failure, wrong=True)

    def _do(self, function: Callable[..., object], *arguments: object) -> str:
        """Do something whose failure must not end the page; returns what went wrong."""
        try:
            function(*arguments)
        except TeleopctlError as error:
            failure = error.message
        except Exception as error:  # noqa: BLE001 -- one button or message must not end the page
            failure = f"{type(error).__name__}: {error}"
        else:
            return ""
        self.get_logger().error(f"The page: {failure}", throttle_duration_sec=_COMPLAINS_EVERY_S)
        return failure

    def destroy_node(self) -> None:
        """Close the page, then the node."""
        for panel in self.panels:
            panel.close()
        self.robot_file.close()
        self._workers.shutdown(wait=False, cancel_futures=True)
        close_server(self.server)
        super().destroy_node()


def open_viewer(
    host: str,
    port: int,
    token_file: Path | None = None,
    *,
    view: Path | None = None,
    panels: list[str] | None = None,
    cli_args: Sequence[str] | None = None,
) -> tuple[Viewer, Address]:
    """Open the page's server and make the node that serves it.

    Args:
        host: See `open_server`, as for ``port``.
        port: See there.
        token_file: The file of the page's token, made where it is missing; by default that of
            `default_token_file` beyond loopback, and none there.
        view: See `Viewer`, as for ``panels`` and ``cli_args``.
        panels: See there.
        cli_args: See there.

    Returns:
        The node, and the page's address.

    Raises:
        TeleopctlError: The page cannot be opened, or the token or the view not be read.
    """
    if token_file is None and not is_loopback(host):
        token_file = default_token_file()
    token = None if token_file is None else read_or_make_token(token_file.absolute())
    server = open_server(host, port, token=token)
    try:
        viewer = Viewer(server, view, panels, cli_args)
    except BaseException:
        close_server(server)
        raise
    return viewer, page_address(host, server.get_port(), token_file and token_file.absolute())
