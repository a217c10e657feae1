"""Metadata of a recording: versions, launch file, robot descriptions and parameters."""

from __future__ import annotations

import json
import math
import os
import platform
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.bag.records import BagAttachment
from teleopctl.base import __version__
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, get_message
from teleopctl.node import (
    AsyncParameterClient,
    ExternalShutdownException,
    Node,
    ShutdownException,
    parameter_document,
    qos_profile_latched,
)

if TYPE_CHECKING:
    from teleopctl.node import ResponseFuture
    from teleopctl.wire import Graph

LAUNCH_VARIABLE = "TELEOPCTL_LAUNCH_OF_RECORDING"
"""Environment variable of a recorded launch: JSON with ``file`` and the mapping ``arguments``."""

RECORD_NAME = "teleopctl"
"""Name of the metadata record with the versions."""

LAUNCH_RECORD_NAME = "teleopctl.launch"
"""Name of the metadata record with the launch file and arguments."""

_DESCRIPTION = "/robot_description"
_DESCRIPTION_TYPE = "std_msgs/msg/String"

# Nodes declare parameters while they start: these are requested (again) this long after a node
# appeared.
_SETTLED_S = 1.0
# Nodes of a launch appear one after the other; requests of such an interval are sent together.
_TOGETHER_S = 0.5
_LONGEST_ANSWER_S = 3.0
# Longest delay of the end of a recording by a node or a description that does not respond.
_LONGEST_END_S = 1.0

# Packages whose versions may change the results of a simulation, an image or a controller.
_LIBRARIES = ("mujoco", "numpy", "eclipse-zenoh", "rosbags", "mcap")


class RecordingMetadata:
    """Thread that adds versions, launch file, robot descriptions and parameters to a bag.

    Existing data is written at once, since a recorder may be killed. Later data, and parameters
    that changed while a node started, are written when they are received, at the latest at the end.

    Args:
        node: Node that requests the parameters and subscribes to the descriptions.
        attach: Called with each attachment to write to the bag.
        add_record: Called with name and values of each metadata record to write to the bag.
        now_ns: Returns the time of attachments, in nanoseconds.
    """

    def __init__(
        self,
        node: Node,
        attach: Callable[[BagAttachment], object],
        add_record: Callable[[str, Mapping[str, str]], object],
        now_ns: Callable[[], int],
    ) -> None:
        self._node = node
        self._attach = attach
        self._add_record = add_record
        self._now_ns = now_ns
        # Set when a description was received, by topic.
        self._descriptions: dict[str, threading.Event] = {}
        # Time of the next parameter request to each node that is starting, by its name.
        self._due_s: dict[str, float] = {}
        self._seen: set[str] = set()
        # Any: YAML values.
        self._documents: dict[str, Any] = {}
        self._parameter_files = 0
        self._changed = threading.Event()
        self._is_over = threading.Event()
        self._end_s = math.inf
        self._thread = threading.Thread(target=self._run, name="bag metadata", daemon=True)
        node.add_graph_callback(self._changed.set)
        self._changed.set()
        self._thread.start()

    def close(self) -> None:
        """Write missing descriptions and parameters to the bag for at most 1 s; stop the thread."""
        self._end_s = time.monotonic() + _LONGEST_END_S
        self._is_over.set()
        self._changed.set()
        self._thread.join(2 * _LONGEST_END_S)

    def join(self) -> None:
        """Wait until all pending requests to nodes have ended, after `close`."""
        self._thread.join()

    def _run(self) -> None:
        try:
            self._write_versions()
            self._write_launch()
            self._note_changes(self._node.graph(), time.monotonic())
            self._gather_parameters(self._seen)
            while not self._is_over.is_set():
                next_s = min(self._due_s.values(), default=None)
                longest_s = None if next_s is None else max(0.0, next_s - time.monotonic())
                self._changed.wait(longest_s)
                self._changed.clear()
                now_s = time.monotonic()
                self._note_changes(self._node.graph(), now_s)
                self._gather_parameters([n for n, due_s in self._due_s.items() if due_s <= now_s])
            self._finish()
        except (TeleopctlError, ShutdownException, ExternalShutdownException) as error:
            if not self._is_over.is_set():
                self._node.get_logger().warning(f"The bag lacks parameters of nodes: {error}")

    def _finish(self) -> None:
        graph = self._node.graph()
        self._note_changes(graph, self._end_s)
        self._gather_parameters([*self._due_s], _LONGEST_END_S / 2)
        for has_come in self._descriptions.values():
            has_come.wait(max(0.0, self._end_s - time.monotonic()))
        # No warning about nodes that have left the graph: they had no time to respond.
        silent = sorted(self._seen & {*graph.node_names()} - {*self._documents})
        if silent:
            self._node.get_logger().warning(
                f"The bag lacks the parameters of {', '.join(silent)}: no answer"
            )

    def _note_changes(self, graph: Graph, now_s: float) -> None:
        """Schedule requests for new nodes, and subscribe to new descriptions."""
        self._follow_descriptions(graph)
        together_s = math.ceil((now_s + _SETTLED_S) / _TOGETHER_S) * _TOGETHER_S
        for name in graph.node_names():
            if name not in self._seen and graph.servers(f"{name}/list_parameters"):
                self._seen.add(name)
                self._due_s[name] = together_s

    def _write_versions(self) -> None:
        from importlib import metadata

        versions = {
            "teleopctl": __version__,
            "python": platform.python_version(),
            "platform": platform.platform(),
            "domain": str(self._node.context.domain_id),
            "command": " ".join(sys.argv),
        }
        for library in _LIBRARIES:
            try:
                versions[library] = metadata.version(library)
            except metadata.PackageNotFoundError:
                continue
        self._add_record(RECORD_NAME, versions)

    def _write_launch(self) -> None:
        text = os.environ.get(LAUNCH_VARIABLE)
        if not text:
            return
        try:
            launch = json.loads(text)
            file, arguments = Path(launch["file"]), dict(launch.get("arguments", {}))
        except (ValueError, KeyError, TypeError) as error:
            self._node.get_logger().warning(f"{LAUNCH_VARIABLE} cannot be read: {error}")
            return
        values = {"file": str(file)} | {f"argument.{k}": str(v) for k, v in arguments.items()}
        self._add_record(LAUNCH_RECORD_NAME, values)
        try:
            data = file.read_bytes()
        except OSError as error:
            self._node.get_logger().warning(f"Cannot read {file}: {error.strerror}")
            return
        self._add_file(f"launch/{file.name}", "text/plain", data)

    def _follow_descriptions(self, graph: Graph) -> None:
        for topic, types in graph.topic_names_and_types():
            if (
                topic.endswith(_DESCRIPTION)
                and _DESCRIPTION_TYPE in types
                and topic not in self._descriptions
                and graph.publishers(topic, _DESCRIPTION_TYPE)
            ):
                self._take_description(topic)

    def _take_description(self, topic: str) -> None:
        string = get_message(_DESCRIPTION_TYPE)
        has_come = self._descriptions[topic] = threading.Event()
        known: set[str] = set()

        def receive(data: bytes) -> None:
            text = deserialize(data, string).data
            # A restarted publisher sends the same description again.
            if text not in known:
                known.add(text)
                number = f"_{len(known)}" if len(known) > 1 else ""
                name = f"{topic.lstrip('/')}{number}.urdf"
                self._add_file(name, "application/xml", text.encode())
            has_come.set()

        self._node.create_subscription(
            string, topic, receive, qos_profile_latched, raw=True, immediate=True
        )

    def _gather_parameters(
        self, names: Collection[str], longest_s: float = _LONGEST_ANSWER_S
    ) -> None:
        """Request the parameters of nodes, and write those that changed."""
        if not names:
            return
        now_s = time.monotonic()
        # A hidden node, so that the clients are in the graph only during the requests.
        with Node(
            f"_{self._node.get_name()}_parameter_requests",
            context=self._node.context,
            enable_rosout=False,
            start_parameter_services=False,
            use_global_arguments=False,
        ) as requester:
            requests = _ParameterRequests(requester, names, self._changed.set)
            self._write_answers(requests, now_s + longest_s)
        for name in names:
            if self._due_s[name] <= now_s:
                del self._due_s[name]
        # Handle graph changes that arrived during the requests.
        self._changed.set()

    def _write_answers(self, requests: _ParameterRequests, deadline_s: float) -> None:
        """Write the received parameters until a deadline or the end of the recording."""
        # Any: YAML values.
        answered: dict[str, Any] = {}
        while True:
            self._changed.clear()
            answered |= requests.step()
            left_s = min(deadline_s, self._end_s) - time.monotonic()
            if not requests.is_pending or left_s <= 0.0:
                break
            # Do not wait for a slow node before writing the parameters of the others.
            if not self._changed.wait(min(left_s, _TOGETHER_S) if answered else left_s):
                self._write_parameters(answered)
                answered = {}
        self._write_parameters(answered)

    # Any: YAML values.
    def _write_parameters(self, documents: Mapping[str, Any]) -> None:
        changed = {
            name: document
            for name, document in documents.items()
            if self._documents.get(name) != document
        }
        if not changed:
            return
        self._documents |= changed
        self._parameter_files += 1
        number = f"_{self._parameter_files}" if self._parameter_files > 1 else ""
        from teleopctl.base import ros_yaml

        text = ros_yaml.dump(changed)
        self._add_file(f"parameters{number}.yaml", "application/yaml", text.encode())

    def _add_file(self, name: str, media_type: str, data: bytes) -> None:
        self._attach(BagAttachment(name, media_type, data, self._now_ns()))


class _ParameterRequests:
    """Requests for all parameters of several nodes, each independent of the others.

    Args:
        node: Node that sends the requests; needs no executor.
        names: Full names of the nodes.
        on_news: Called from any thread when `step` has a response to handle.
    """

    def __init__(self, node: Node, names: Iterable[str], on_news: Callable[[], object]) -> None:
        self._on_news = on_news
        self._remotes = {name: AsyncParameterClient(node, name) for name in names}
        # Any: responses, whose types are created at run time.
        self._lists: dict[str, ResponseFuture[Any]] = {}
        self._values: dict[str, tuple[list[str], ResponseFuture[Any]]] = {}
        for name, remote in self._remotes.items():
            self._lists[name] = self._watched(remote.list_parameters())

    @property
    def is_pending(self) -> bool:
        """Whether any node has not answered its parameter requests yet."""
        return bool(self._lists or self._values)

    # Any: YAML values.
    def step(self) -> dict[str, Any]:
        """Handle received responses; return parameters of nodes whose responses are complete."""
        for name, future in [*self._lists.items()]:
            if future.is_settled():
                del self._lists[name]
                if (answer := _response_of(future)) is not None:
                    wanted = sorted(answer.result.names)
                    values = self._remotes[name].get_parameters(wanted)
                    self._values[name] = wanted, self._watched(values)
        documents: dict[str, Any] = {}
        for name, (wanted, future) in [*self._values.items()]:
            if future.is_settled():
                del self._values[name]
                if (answer := _response_of(future)) is not None:
                    pairs = zip(wanted, answer.values, strict=False)
                    documents |= parameter_document(name, pairs)
        return documents

    def _watched(self, future: ResponseFuture[Any]) -> ResponseFuture[Any]:
        future.on_end(self._on_news)
        future.on_unanswered(self._on_news)
        return future


# Any: a response, whose type is created at run time.
def _response_of(future: ResponseFuture[Any]) -> Any:
    """Return the response of a settled future; None if the request failed."""
    if not future.done() or future.cancelled() or future.exception() is not None:
        return None
    return future.result()
