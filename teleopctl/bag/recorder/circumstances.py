"""What somebody needs years later to understand a recording, gathered while it runs."""

from __future__ import annotations

import json
import os
import platform
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl import __version__
from teleopctl.bag.records import BagAttachment
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, get_message
from teleopctl.node import (
    Node,
    NotInitializedException,
    ShutdownException,
    ask_nodes,
    parameter_document,
    qos_profile_latched,
)

if TYPE_CHECKING:
    from teleopctl.wire import Graph

LAUNCH_VARIABLE = "TELEOPCTL_LAUNCH_OF_RECORDING"
"""Set by a launch that records itself: JSON with ``file`` and ``arguments``, a mapping."""

RECORD_NAME = "teleopctl"
"""The record of metadata with the versions."""

LAUNCH_RECORD_NAME = "teleopctl.launch"
"""The record of metadata with the launch file and its arguments."""

_DESCRIPTION = "/robot_description"
_DESCRIPTION_TYPE = "std_msgs/msg/String"

# While nodes start, they come one after the other; their parameters are asked for together.
_QUIET_S = 1.0
_LONGEST_ANSWER_S = 3.0

# Of what may be installed: what a simulation, a picture or a controller may depend on.
_LIBRARIES = ("mujoco", "numpy", "eclipse-zenoh", "rosbags", "mcap")


class Circumstances:
    """Gathers versions, the launch, robot descriptions and parameters, on a thread of its own.

    Args:
        node: Who looks at the graph.
        attach: Called with each file that is to stand in the bag.
        add_record: Called with each record of metadata that is to.
        now_ns: The time that attachments bear.
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
        self._descriptions: set[str] = set()
        self._asked: set[str] = set()
        self._parameter_files = 0
        self._changed = threading.Event()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="bag circumstances", daemon=True)
        node.add_graph_callback(self._changed.set)
        self._changed.set()
        self._thread.start()

    def close(self) -> None:
        """Gather nothing more; questions that were sent may still wait for answers."""
        self._is_over.set()
        self._changed.set()

    def join(self) -> None:
        """Wait until nothing is asked any more, after `close`."""
        self._thread.join()

    def _run(self) -> None:
        try:
            self._tell_versions()
            self._tell_launch()
            while not self._is_over.is_set():
                self._changed.wait()
                self._gather()
        except (TeleopctlError, ShutdownException, NotInitializedException) as error:
            if not self._is_over.is_set():
                self._node.get_logger().warning(f"The bag lacks parameters of nodes: {error}")

    def _gather(self) -> None:
        # Once the graph has been quiet for a while.
        while not self._is_over.is_set() and self._changed.is_set():
            self._changed.clear()
            self._follow_descriptions(self._node.graph())
            self._changed.wait(_QUIET_S)
        if not self._is_over.is_set():
            self._gather_parameters(self._node.graph())

    def _tell_versions(self) -> None:
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

    def _tell_launch(self) -> None:
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
                self._descriptions.add(topic)
                self._take_description(topic)

    def _take_description(self, topic: str) -> None:
        string = get_message(_DESCRIPTION_TYPE)
        known: set[str] = set()

        def receive(data: bytes) -> None:
            text = deserialize(data, string).data
            # A publisher that starts anew says the same again.
            if text not in known:
                known.add(text)
                number = f"_{len(known)}" if len(known) > 1 else ""
                name = f"{topic.lstrip('/')}{number}.urdf"
                self._add_file(name, "application/xml", text.encode())

        self._node.create_subscription(
            string, topic, receive, qos_profile_latched, raw=True, immediate=True
        )

    def _gather_parameters(self, graph: Graph) -> None:
        names = [
            name
            for name in dict.fromkeys(graph.node_names())
            if name not in self._asked and graph.servers(f"{name}/list_parameters")
        ]
        self._asked.update(names)
        if not names:
            return
        # Its clients are in the graph only while it asks, and hidden.
        with Node(
            f"_{self._node.get_name()}_questions",
            context=self._node.context,
            enable_rosout=False,
            start_parameter_services=False,
            use_global_arguments=False,
        ) as questions:
            documents = read_parameters(questions, names)
        if not documents:
            return
        import yaml

        self._parameter_files += 1
        number = f"_{self._parameter_files}" if self._parameter_files > 1 else ""
        text = yaml.safe_dump(documents, allow_unicode=True)
        self._add_file(f"parameters{number}.yaml", "application/yaml", text.encode())

    def _add_file(self, name: str, media_type: str, data: bytes) -> None:
        self._attach(BagAttachment(name, media_type, data, self._now_ns()))


# Any, here and below: YAML's values.
def read_parameters(node: Node, names: Iterable[str]) -> dict[str, Any]:
    """Ask nodes for all of their parameters, and return them as parameter files have them.

    Nodes that do not answer are left out.

    Args:
        node: Who asks; it needs no executor for this.
        names: Full names of the nodes.
    """
    lists = ask_nodes(node, names, lambda remote: remote.list_parameters(), _LONGEST_ANSWER_S)
    wanted = {
        name: sorted(answer.result.names)
        for name, answer in lists.items()
        if not isinstance(answer, TeleopctlError)
    }
    values = ask_nodes(
        node,
        wanted,
        lambda remote: remote.get_parameters(wanted[remote.remote_node_name]),
        _LONGEST_ANSWER_S,
    )
    documents: dict[str, Any] = {}
    for name, answer in values.items():
        if not isinstance(answer, TeleopctlError):
            documents |= parameter_document(name, zip(wanted[name], answer.values, strict=False))
    return documents
