"""The viewer: a node that serves a page with the 3D view and the panels.

Displays and panels run on the node's thread: messages are received there, events of the page are
passed to it, and a timer updates the scene 30 times a second while a browser shows the page.
Otherwise the timer is stopped, and displays and panels are unsubscribed.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from teleopctl.base.token_file import Address
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service, known_types
from teleopctl.node import Clock, ClockType, Node, QoSProfile
from teleopctl.tf import NamedTransformListener, Transform
from teleopctl.viewer.html import links_html
from teleopctl.viewer.layout import PageLayout
from teleopctl.viewer.page_server import (
    CLEANUP_PERIOD_S,
    MemoryCleanup,
    close_server,
    open_page,
)
from teleopctl.viewer.panels.plots.collected import CollectedSamples
from teleopctl.viewer.robot_file import RobotFile
from teleopctl.viewer.robot_stop import RobotStopControl
from teleopctl.viewer.scene.frames import FrameBuffer, LargeTransforms, SceneFrames
from teleopctl.viewer.scene_view import SceneView
from teleopctl.viewer.subscriptions import SharedSubscriptions, UnknownTypes
from teleopctl.viewer.workspace import PageWorkspace

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.client_tracker import PageServer
    from teleopctl.viewer.displays.base import Stage
    from teleopctl.viewer.page_routes import PageRoutes
    from teleopctl.viewer.panels.plots.recorded import Recording

_T = TypeVar("_T")

_UPDATES_PER_S = 30.0
# Moving thousands of frames takes longer than a period: between two updates of frames there are at
# least this many times the length of one, so that the page answers in between.
_REST = 2.0
# Panels are updated with every third update of the scene.
_UPDATES_PER_PANEL_TICK = 3
# What was arranged is kept in the browsers every two seconds.
_UPDATES_PER_STORE = 60
_ERROR_PERIOD_S = 5.0
# Larger steps of ROS time in the time between two updates are jumps.
_JUMP_S, _FASTEST = 1.0, 100.0
# Time for a browser to reconnect after a reload or a broken connection.
_HIDDEN_AFTER_S = 5.0


class Viewer(Node):
    """Node ``rviz`` that serves a web page with the 3D view and the panels.

    Args:
        server: The page's server.
        view: The ``.rviz`` file to load; None for the default displays.
        layout: Layout of the panels; None to choose one by what is there.
        cli_args: ROS arguments for this node, in addition to those of the process.
        links: Titles of the server's other pages by path, to which the page has links.
    """

    def __init__(
        self,
        server: PageServer,
        view: Path | None = None,
        layout: PageLayout | None = None,
        cli_args: Sequence[str] | None = None,
        links: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__("rviz", cli_args=cli_args)
        self.node = self
        self.stage = self
        self.server = server
        server.client_errors.log = self.get_logger().warning
        self.scene = server.scene
        self.gui = server.gui
        self._watched = False
        self._updates = 0
        self._next_frames_s = 0.0
        self._last_time_ns, self._last_tick_s = 0, 0.0
        self._queue: deque[Callable[[], object]] = deque()
        self._queued = self.create_guard_condition(self._run_queued)
        self._types = UnknownTypes(self, self.run_in_background)
        self._subscriptions = SharedSubscriptions(self, self.guarded, self.notify)
        self._shared: dict[Callable[[Stage], Any], Any] = {}
        self._workers = ThreadPoolExecutor(2, thread_name_prefix="work")
        self.buffer = FrameBuffer(self)
        self.frames = SceneFrames(server.scene, self.buffer)
        self._listener: NamedTransformListener | None = None
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0 / _UPDATES_PER_S, self._tick, clock=steady)
        self._timer.cancel()
        self._hide_timer = self.create_timer(
            _HIDDEN_AFTER_S, lambda: self.guarded(self._end_showing), clock=steady
        )
        self._hide_timer.cancel()
        self.create_timer(CLEANUP_PERIOD_S, MemoryCleanup(server).run, clock=steady)
        simulated = bool(self.get_parameter("use_sim_time").value)
        self.scene_view = SceneView(server, self, view, simulated=simulated)
        self.robot_file = RobotFile(self)
        self.create_service(get_service("std_srvs/srv/Empty"), "~/reset_time", self._reset_time)
        self._robot_stop = RobotStopControl(self)
        if links:
            self.gui.add_html(links_html(links))
        self.workspace = PageWorkspace(server, self, layout)
        self.add_graph_callback(lambda: self.call_on_node_thread(self._on_graph_change))
        server.on_client_connect(self.on_node_thread(self._add_client))
        server.on_client_disconnect(self.on_node_thread(self._remove_client))
        server.clients.on_change(self.on_node_thread(self._update_visibility))
        server.clients.on_click(self.on_node_thread(self.workspace.clicked))
        self._time_source.rest(is_resting=True)

    def _add_client(self, client: viser.ClientHandle) -> None:
        self.workspace.add_client(client)
        self._update_visibility()

    def _remove_client(self, client: viser.ClientHandle) -> None:
        self.workspace.remove_client(client.client_id)
        self._update_visibility()

    # --- for displays and panels --------------------------------------------------------------

    # Any, here and below: messages of any type, results of any task, and YAML values.
    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: QoSProfile
    ) -> Callable[[], None]:
        """Subscribe to a topic once its type is known; return a function that unsubscribes.

        The definition of an unknown type is requested first; see `Stage.knows_type`.
        """

        def begin() -> Callable[[], None]:
            return self._subscriptions.subscribe(topic, type_name, callback, qos)

        return (
            begin() if self.knows_type(type_name) else self._types.call_when_known(type_name, begin)
        )

    def knows_type(self, type_name: str) -> bool:
        """Return whether the definition of a message type is known; see `Stage.knows_type`."""
        return known_types().find(type_name) is not None

    @property
    def robot_folder(self) -> Path | None:
        """Folder of the robot's description file; None if unknown."""
        path = self.robot_file.path
        return None if path is None else path.parent

    def camera(self) -> Transform | None:
        """Return the pose of the camera that was moved last; see `Stage.camera`."""
        return self.scene_view.camera()

    def run_in_background(self, task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        """Run a task in another thread; call ``then(result or exception)`` on the node's thread."""

        def run() -> None:
            try:
                result = task()
            except Exception as error:  # noqa: BLE001 -- passed to the caller
                result = error
            self.call_on_node_thread(lambda: then(result))

        self._workers.submit(run)

    def call_on_node_thread(self, function: Callable[[], object]) -> None:
        """Queue a function to be called on the node's thread; any thread may call this."""
        self._queue.append(function)
        self._queued.trigger()

    def on_node_thread(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback for viser that queues a call of ``function`` on the node's thread."""

        def hand_over(*arguments: Any) -> None:
            self.call_on_node_thread(lambda: function(*arguments))

        return hand_over

    def reset(self) -> None:
        """Clear the tf buffer and all displays, as RViz's Reset does."""
        self.buffer.clear()
        self.scene_view.reset()

    def shared(self, kind: Callable[[Stage], _T]) -> _T:
        """Return what the panels of all browsers share; see `Page.shared`."""
        if kind not in self._shared:
            self._shared[kind] = kind(self)
        made: _T = self._shared[kind]
        return made

    def plot_recording(self, recording: Recording) -> None:
        """Read what is plotted from a recording, the whole of it, while a player plays it.

        Args:
            recording: The recording.
        """
        self.shared(CollectedSamples).recording = recording

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification for 8 s in all browsers that have the page open."""
        self.server.notify(title, text, wrong=wrong)

    def run_script(self, client_id: int, script: str) -> None:
        """Run a script of ours, without anything from the network in it, in one browser."""
        self.server.run_script(client_id, script)

    def fill(self, texts: Mapping[str, str]) -> None:
        """Set the text of elements of the page's HTML in all browsers, by the elements' IDs."""
        self.server.fill(texts)

    # --- updates ------------------------------------------------------------------------------

    @property
    def is_visible(self) -> bool:
        """Whether a browser shows the page."""
        return any(map(self.server.clients.is_visible, self.server.get_clients()))

    def _update_visibility(self) -> None:
        """Start or stop updates by whether a browser shows the page, stopping after 5 s only.

        Subscriptions are kept for a browser that reconnects within that time, so plots continue.
        Zenoh keeps some memory for each new subscription, in every process (docs/robustness.md,
        Soak).
        """
        if not self.is_visible:
            if self._watched:
                self._hide_timer.reset()
            return
        self._hide_timer.cancel()
        if not self._watched:
            self._begin_showing()
        self.workspace.show_visible(is_watched=True)

    def _begin_showing(self) -> None:
        self._watched = True
        self._time_source.rest(is_resting=False)
        self._listener = NamedTransformListener(self.buffer, self)
        self._listener.tf_sub.choose_by_size(LargeTransforms().is_taken)
        self.scene_view.begin()
        self._timer.reset()

    def _end_showing(self) -> None:
        self._hide_timer.cancel()
        self._watched = False
        self._timer.cancel()
        if self._listener is not None:
            self._listener.unregister()
            self._listener = None
        self.scene_view.end()
        self.workspace.show_visible(is_watched=False)
        self._time_source.rest(is_resting=True)

    # Any: request and response of RViz's service for its Reset.
    def _reset_time(self, _request: Any, response: Any) -> Any:
        self.guarded(self.reset)
        return response

    def _on_graph_change(self) -> None:
        self._types.request_missing()
        self.guarded(self._robot_stop.graph_changed)
        self.guarded(self.scene_view.offer_topics, self.get_topic_names_and_types())
        self.guarded(self.workspace.graph_changed)

    def _tick(self) -> None:
        self._updates += 1
        now_ns = self.get_clock().now().nanoseconds
        begun_s = time.monotonic()
        passed_s = (now_ns - self._last_time_ns) * 1e-9
        jumped_back = passed_s < 0.0
        # Ahead, as after a seek in a bag: simulations are not as fast.
        jumped = jumped_back or passed_s > _JUMP_S + _FASTEST * (begun_s - self._last_tick_s)
        self._last_time_ns, self._last_tick_s = now_ns, begun_s
        if jumped:
            self.workspace.time_jumped()
        with self.server.atomic():
            if begun_s >= self._next_frames_s:
                self.guarded(self.frames.update)
                self._next_frames_s = begun_s + _REST * (time.monotonic() - begun_s)
            self.guarded(lambda: self.scene_view.tick(jumped_back=jumped_back))
        if self._updates % _UPDATES_PER_PANEL_TICK == 0:
            self.workspace.tick()
        if self._updates % _UPDATES_PER_STORE == 0:
            self.guarded(self.workspace.store)

    def _run_queued(self) -> None:
        # Functions queued by these calls are called at the next trigger, after pending messages.
        for _ in range(len(self._queue)):
            failure = self.guarded(self._queue.popleft())
            if failure:
                self.notify("Error", failure, wrong=True)

    def guarded(self, function: Callable[..., object], *arguments: object) -> str:
        """Call a function; log its exception, and return its message, empty for none."""
        try:
            function(*arguments)
        except TeleopctlError as error:
            failure = error.message
        except Exception as error:  # noqa: BLE001 -- one button or message must not end the page
            failure = f"{type(error).__name__}: {error}"
        else:
            return ""
        self.get_logger().error(f"The page: {failure}", throttle_duration_sec=_ERROR_PERIOD_S)
        return failure

    def destroy_node(self) -> None:
        """Close the panels and the page's web server, then destroy the node."""
        self.workspace.close()
        self.robot_file.close()
        self._workers.shutdown(wait=False, cancel_futures=True)
        close_server(self.server)
        super().destroy_node()


def open_viewer(
    host: str,
    port: int | None,
    token_file: Path | None = None,
    *,
    view: Path | None = None,
    layout: PageLayout | None = None,
    cli_args: Sequence[str] | None = None,
    routes: PageRoutes | None = None,
) -> tuple[Viewer, Address]:
    """Open the page's web server; return the `Viewer` node that serves it, and the page's address.

    Args:
        host: Address to listen on.
        port: Port to listen on; see `open_server`.
        token_file: File of the page's token; see `open_page`.
        view: See `Viewer`.
        layout: See `Viewer`.
        cli_args: See `Viewer`.
        routes: See `open_server`.

    Returns:
        The node, and the page's URL.

    Raises:
        TeleopctlError: The page cannot be opened, or the token or view file cannot be read.
    """
    server, address = open_page(host, port, token_file, routes=routes)
    try:
        viewer = Viewer(server, view, layout, cli_args, None if routes is None else routes.links)
    except BaseException:
        close_server(server)
        raise
    return viewer, address
