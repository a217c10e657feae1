"""A context: one Zenoh session, one counter of entity ids, one lifetime, shared by its nodes."""

from __future__ import annotations

import itertools
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from types import FrameType
from typing import TYPE_CHECKING, ClassVar, Literal

from teleopctl.node.exceptions import NotInitializedException
from teleopctl.node.ros_args import RosArguments, parse_ros_arguments

if TYPE_CHECKING:
    import zenoh

    from teleopctl.wire.graph import GraphWatcher

SessionMode = Literal["peer", "client"]


class Context:
    """What ``init()`` starts and ``shutdown()`` ends.

    The session is opened when the first node needs it. One process normally has one context,
    :meth:`default`.
    """

    _default: ClassVar[Context | None] = None
    _default_lock: ClassVar[threading.Lock] = threading.Lock()

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._running = False
        self._ended_by_signal = False
        self._session: zenoh.Session | None = None
        self._session_mode: SessionMode = "peer"
        self._watcher: GraphWatcher | None = None
        self._ids = itertools.count()
        self._on_shutdown: list[Callable[[], None]] = []
        self._on_graph_change: list[Callable[[], None]] = []
        self._previous_sigterm: signal._HANDLER = None
        self.domain_id = 0
        self.arguments = RosArguments()

    @classmethod
    def default(cls) -> Context:
        """Return the context that is used where none is given."""
        with cls._default_lock:
            if cls._default is None:
                cls._default = cls()
            return cls._default

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        domain_id: int | None = None,
        session_mode: SessionMode = "peer",
    ) -> None:
        """Start the context.

        Args:
            args: Command line with ``--ros-args`` groups; None takes ``sys.argv``.
            domain_id: ROS domain; None takes ``ROS_DOMAIN_ID``, else 0.
            session_mode: ``peer`` for anything that lives or streams, ``client`` for one-shot
                commands (opens faster, needs a router).

        Raises:
            RuntimeError: The context runs already.
            TeleopctlError: A ROS argument or the domain is malformed.
        """
        from teleopctl.wire.session import domain_id as domain_of_environment

        with self._lock:
            if self._running:
                raise RuntimeError("Context.init() must only be called once")
            self.arguments = parse_ros_arguments(sys.argv if args is None else args)
            self.domain_id = domain_of_environment() if domain_id is None else domain_id
            self._session_mode = session_mode
            self._ids = itertools.count()
            self._ended_by_signal = False
            self._running = True
        if threading.current_thread() is threading.main_thread():
            self._previous_sigterm = signal.signal(signal.SIGTERM, self._handle_sigterm)

    def ok(self) -> bool:
        """Return True between ``init()`` and ``shutdown()``."""
        return self._running

    @property
    def ended_by_signal(self) -> bool:
        """True when SIGTERM ended the context, so that spinning raises instead of returning."""
        return self._ended_by_signal

    @property
    def session(self) -> zenoh.Session:
        """The Zenoh session, opened on first use.

        Raises:
            NotInitializedException: The context is not running.
        """
        if self._session is None:
            from teleopctl.wire.session import open_session

            with self._lock:
                if not self._running:
                    raise NotInitializedException
                if self._session is None:
                    self._session = open_session(self._session_mode)
        return self._session

    @property
    def session_is_open(self) -> bool:
        """True while there is a session to undeclare things from."""
        return self._session is not None and not self._session.is_closed()

    @property
    def watcher(self) -> GraphWatcher:
        """The live graph, watched from first use on."""
        if self._watcher is None:
            from teleopctl.wire.graph import GraphWatcher

            with self._lock:
                if self._watcher is None:
                    self._watcher = GraphWatcher(
                        self.session, self.domain_id, self._tell_graph_change
                    )
        return self._watcher

    def on_graph_change(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` after each change of the graph, on the transport's thread."""
        with self._lock:
            self._on_graph_change.append(callback)
        _ = self.watcher

    def _tell_graph_change(self) -> None:
        for callback in tuple(self._on_graph_change):
            callback()

    def next_id(self) -> int:
        """Return the next entity id of the session: nodes and endpoints share one counter."""
        return next(self._ids)

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` when the context is shut down."""
        with self._lock:
            self._on_shutdown.append(callback)

    def forget_on_shutdown(self, callback: Callable[[], None]) -> None:
        """Take a callback back; unknown ones are ignored."""
        with self._lock:
            if callback in self._on_shutdown:
                self._on_shutdown.remove(callback)

    def shutdown(self) -> None:
        """End the context: wake everything that waits, then close the session.

        Raises:
            RuntimeError: It does not run.
        """
        if not self._running:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        self.try_shutdown()

    def try_shutdown(self) -> None:
        """End the context if it runs."""
        self._end()
        with self._lock:
            session, self._session = self._session, None
            watcher, self._watcher = self._watcher, None
        if watcher is not None:
            watcher.close()
        if session is not None:
            session.close()  # type: ignore[no-untyped-call]
        if self._previous_sigterm is not None:
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGTERM, self._previous_sigterm)
            self._previous_sigterm = None

    def _end(self) -> None:
        """Mark the context as ended and tell everybody, leaving the session open."""
        with self._lock:
            if not self._running:
                return
            self._running = False
            callbacks, self._on_shutdown = self._on_shutdown, []
        for callback in callbacks:
            callback()

    def _handle_sigterm(self, signum: int, frame: FrameType | None) -> None:
        """Let spinning stop; whoever spins destroys the nodes and shuts down for good."""
        self._ended_by_signal = True
        self._end()
        if callable(self._previous_sigterm):
            self._previous_sigterm(signum, frame)

    def __enter__(self) -> Context:
        if not self._running:
            self.init()
        return self

    def __exit__(self, *_: object) -> None:
        self.try_shutdown()
