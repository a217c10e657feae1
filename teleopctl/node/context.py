"""Contexts: lifetime, Zenoh session and graph watcher that the nodes of a process share."""

from __future__ import annotations

import _thread
import atexit
import itertools
import sys
import threading
import time
from collections.abc import Callable, Sequence

from teleopctl.base.typed import TYPE_CHECKING, ClassVar, Literal, suppress
from teleopctl.node.values import signals
from teleopctl.node.values.exceptions import NotInitializedException, ShutdownBySignalException
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.ros_args import RosArguments, parse_ros_arguments

if TYPE_CHECKING:
    import zenoh
    from zenoh import LivelinessToken

    from teleopctl.node.shared_subscriber import SharedSubscribers
    from teleopctl.node.values.library_logging import LibraryLogs
    from teleopctl.wire import Graph, GraphWatcher

    SessionMode = Literal["peer", "client"]

# Time limit of the first query of the graph, which takes about a millisecond.
_FIRST_QUERY_S = 1.0
# Longest wait for peers that have no tokens yet, in seconds. They take some milliseconds; peers
# without nodes in this domain reply as fast, if their administration space is on.
_NEW_PEERS_S = 0.1

# Longest wait for daemon threads at exit. Without a session, publishing raises and spinning ends;
# a thread that does neither may continue.
_LONGEST_JOIN_S = 0.1


class Context:
    """ROS state of a process between ``init()`` and ``shutdown()``, with a Zenoh session.

    The session is opened when the first node needs it. One process normally has one context,
    `default`.

    Attributes:
        publishes_after_signal: Whether publishers still send after a signal, until `shutdown`; for
            programs that shut down by themselves and publish last messages, such as the final
            commands of controllers.
    """

    _default: ClassVar[Context | None] = None
    _default_lock: ClassVar[threading.Lock] = threading.Lock()

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._running = False
        # True from init() until shutdown() has released everything; a signal clears `_running`.
        self._initialized = False
        self._ended_by_signal = False
        self.publishes_after_signal = False
        self._session: zenoh.Session | None = None
        self._session_mode: SessionMode = "peer"
        self._shared_subscribers: SharedSubscribers | None = None
        self._watcher: GraphWatcher | None = None
        self._ids = itertools.count()
        self._on_shutdown: list[Callable[[], None]] = []
        self._on_graph_change: list[Callable[[], None]] = []
        self._graph_changed = threading.Condition()
        # Keys of this process's tokens; a dict, whose changes are atomic.
        self._announced: dict[str, None] = {}
        self.domain_id = 0
        self._initialize_logging = True
        self._library_logs: LibraryLogs | None = None
        self.arguments = RosArguments()

    @classmethod
    def default(cls) -> Context:
        """Return the default context of the process, created on first use."""
        with cls._default_lock:
            if cls._default is None:
                cls._default = cls()
            return cls._default

    @classmethod
    def release_default(cls) -> Context:
        """Return the default context; the next use of the default creates a new one (ours)."""
        context = cls.default()
        with cls._default_lock:
            if cls._default is context:
                cls._default = None
        return context

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
        session_mode: SessionMode = "peer",
        signal_handler_options: signals.SignalHandlerOptions | None = None,
        publishes_after_signal: bool = False,
    ) -> None:
        """Initialize the context from command-line arguments, and install its signal handlers.

        Args:
            args: Command line with ``--ros-args`` groups; None takes ``sys.argv``.
            domain_id: ROS domain; None takes ``ROS_DOMAIN_ID``, else 0.
            session_mode: Mode of the Zenoh session: ``peer`` for long-running programs, ``client``
                for one-shot commands (opens faster, needs a router).
            initialize_logging: Whether log records of Python libraries are passed to the nodes'
                loggers; see `library_logging`. Takes the import of ``logging``.
            signal_handler_options: Signals that end the context; SIGINT and SIGTERM if None.
                Ctrl-C raises KeyboardInterrupt in any case.
            publishes_after_signal: Whether publishers still send after a signal, until `shutdown`.

        Raises:
            RuntimeError: The context is running already, or the domain is negative.
            TeleopctlError: A ROS argument or the domain is malformed.
        """
        from teleopctl.wire import domain_id as domain_of_environment

        with self._lock:
            if self._running:
                raise RuntimeError("Context.init() must only be called once")
            if domain_id is not None and domain_id < 0:
                raise RuntimeError(f"the ROS domain id must not be negative, got {domain_id}")
            self.try_shutdown()
            self.arguments = parse_ros_arguments(sys.argv if args is None else args)
            self.domain_id = domain_of_environment() if domain_id is None else domain_id
            self._session_mode = session_mode
            self.publishes_after_signal = publishes_after_signal
            self._initialize_logging = initialize_logging
            self._ids = itertools.count()
            self._announced.clear()
            self._ended_by_signal = False
            self._initialized = True
            self._running = True
        # A session closed by the interpreter's end may wait for threads that no longer run.
        atexit.register(self._end_with_program)
        every = signals.SignalHandlerOptions.ALL
        options = every if signal_handler_options is None else signal_handler_options
        signals.install_signal_handlers(self, options)

    def ok(self) -> bool:
        """Return whether the context is initialized and neither shut down nor ended by a signal."""
        return self._running

    @property
    def ended_by_signal(self) -> bool:
        """Whether a signal ended the context, so that spinning raises instead of returning."""
        return self._ended_by_signal

    def not_running_error(self) -> NotInitializedException:
        """Return the exception for a use of the context while it does not run (ours)."""
        return ShutdownBySignalException() if self._ended_by_signal else NotInitializedException()

    @property
    def session(self) -> zenoh.Session:
        """Zenoh session of the context, opened on first use.

        Raises:
            NotInitializedException: The context is not running.
        """
        if self._session is None:
            from teleopctl.wire import open_session

            with self._lock:
                if not self._running:
                    raise self.not_running_error()
                if self._session is None:
                    self._session = open_session(self._session_mode)
                    # Loaded by programs that report their progress, and by no short command.
                    if progress := sys.modules.get("teleopctl.base.progress"):
                        progress.report_session(str(self._session.zid()))
        return self._session

    @property
    def shared_subscribers(self) -> SharedSubscribers:
        """Pool of Zenoh subscribers that the context's subscriptions share; made on first use."""
        session = self.session
        with self._lock:
            if self._shared_subscribers is None:
                from teleopctl.node.shared_subscriber import SharedSubscribers

                self._shared_subscribers = SharedSubscribers(session)
            return self._shared_subscribers

    @property
    def session_is_open(self) -> bool:
        """Whether the context's Zenoh session is open."""
        return self._session is not None and not self._session.is_closed()

    @property
    def watcher(self) -> GraphWatcher:
        """Graph watcher of the context, started on first use."""
        if self._watcher is None:
            with self._lock:
                if self._watcher is not None:
                    return self._watcher
                self._watcher = self._start_watcher()
            # Changes during the watcher's construction have not been reported.
            self._notify_graph_change()
        return self._watcher

    def announce(self, token_key: str) -> LivelinessToken:
        """Declare a node's or endpoint's liveliness token, given its key; return the token."""
        # Before declaring: a watcher under construction either finds the token here or receives it.
        self._announced[token_key] = None
        try:
            return self.session.liveliness().declare_token(token_key)
        except BaseException:
            self._announced.pop(token_key, None)
            raise

    def withdraw(self, token: LivelinessToken, token_key: str) -> None:
        """Undeclare a liveliness token, and remove its entity from the local graph at once."""
        self._announced.pop(token_key, None)
        token.undeclare()
        if self._watcher is not None:
            self._watcher.remove_own_token(token_key)

    def _start_watcher(self) -> GraphWatcher:
        """Return a watcher that has all tokens of the present graph."""
        from teleopctl.wire import GraphWatcher, query_graph, wait_for_peer_tokens

        # A query beside a watcher may lack tokens; see `query_graph`.
        present = query_graph(self.session, self.domain_id, _FIRST_QUERY_S)
        known = {node.zid for node in present.nodes}
        if wait_for_peer_tokens(self.session, _NEW_PEERS_S, except_for=known):
            present = query_graph(self.session, self.domain_id, _FIRST_QUERY_S)
        watcher = GraphWatcher(self.session, self.domain_id, self._notify_graph_change)
        # Zenoh 1.10 sometimes delivers tokens that the session declared before with a delay.
        for token_key in tuple(self._announced):
            watcher.add_own_token(token_key)
            if token_key not in self._announced:
                watcher.remove_own_token(token_key)
        # Only tokens of other sessions: new own tokens would count for others that are missing.
        own = str(self.session.zid())

        def of_others(graph: Graph) -> tuple[int, int]:
            return (
                sum(endpoint.zid != own for endpoint in graph.endpoints),
                sum(node.zid != own for node in graph.nodes),
            )

        endpoints, nodes = of_others(present)

        def is_complete(graph: Graph) -> bool:
            known_endpoints, known_nodes = of_others(graph)
            return known_endpoints >= endpoints and known_nodes >= nodes

        watcher.wait_for(is_complete, _FIRST_QUERY_S)
        return watcher

    def on_graph_change(self, callback: Callable[[], None]) -> None:
        """Register a function to call after each graph change, on the reporting thread."""
        with self._lock:
            self._on_graph_change.append(callback)
        _ = self.watcher

    def forget_on_graph_change(self, callback: Callable[[], None]) -> None:
        """Unregister a function of `on_graph_change`; unknown ones are ignored."""
        with self._lock:
            if callback in self._on_graph_change:
                self._on_graph_change.remove(callback)

    def wait_for_graph(self, predicate: Callable[[Graph], bool], timeout_s: float | None) -> bool:
        """Block until the graph satisfies a predicate; return False on timeout or shutdown.

        Returns:
            False on timeout, which is in seconds of wall time, or after a shutdown of the context.
        """
        watcher = self.watcher
        return self.wait_for_change(lambda: predicate(watcher.snapshot()), timeout_s)

    def wait_for_change(self, predicate: Callable[[], bool], timeout_s: float | None) -> bool:
        """Block until a predicate holds, checked at graph changes; False on timeout or shutdown."""
        _ = self.watcher
        with self._graph_changed:
            return (
                self._graph_changed.wait_for(lambda: not self._running or predicate(), timeout_s)
                and self._running
            )

    def _notify_graph_change(self) -> None:
        if self._watcher is None:
            return
        with self._graph_changed:
            self._graph_changed.notify_all()
        for callback in tuple(self._on_graph_change):
            callback()

    def next_id(self) -> int:
        """Return a new entity id, the next number of the session, for a node or an endpoint."""
        return next(self._ids)

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Register a function to call once when the context is shut down or ended by a signal."""
        with self._lock:
            self._on_shutdown.append(callback)

    def forget_on_shutdown(self, callback: Callable[[], None]) -> None:
        """Unregister a function of `on_shutdown`; unknown ones are ignored."""
        with self._lock:
            if callback in self._on_shutdown:
                self._on_shutdown.remove(callback)

    def add_node_logger(self, name: str) -> None:
        """Register a node's logger, by name, for Python log records; the oldest logger gets all."""
        if not self._initialize_logging:
            return
        with self._lock:
            if self._library_logs is None:
                from teleopctl.node.values.library_logging import LibraryLogs

                self._library_logs = LibraryLogs()
            self._library_logs.nodes.append(name)

    def remove_node_logger(self, name: str) -> None:
        """Unregister a logger of `add_node_logger` by name; unknown names are ignored."""
        with self._lock:
            if self._library_logs is not None and name in self._library_logs.nodes:
                self._library_logs.nodes.remove(name)

    def destroy(self) -> None:
        """Shut the context down if it is initialized; same as `try_shutdown`."""
        self.try_shutdown()

    @property
    def handle(self) -> Handle:
        """Handle of the context, as in rclpy."""
        return Handle(self)

    @property
    def is_destroyed(self) -> bool:
        """Whether the context is not initialized or was shut down (ours)."""
        return not self._initialized

    def get_domain_id(self) -> int:
        """Return the ROS domain id of the context."""
        return self.domain_id

    def shutdown(self) -> None:
        """Shut the context down, closing its Zenoh session; raise RuntimeError if not initialized.

        Raises:
            RuntimeError: The context was not initialized, or was shut down already.
        """
        if not self._initialized:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        self.try_shutdown()

    def try_shutdown(self) -> None:
        """Shut the context down if it is initialized; else do nothing."""
        self._running = False
        self._notify_shutdown()
        self._release()
        signals.uninstall_signal_handlers(self)

    def _end_with_program(self) -> None:
        """Shut the context down at interpreter exit, and wait briefly for daemon threads.

        Up to version 3.13 Python unwinds a thread that waits for the GIL at exit. If the thread is
        in Zenoh's code, the process aborts with "FATAL: exception not rethrown".
        """
        self.try_shutdown()
        deadline = time.monotonic() + _LONGEST_JOIN_S
        for thread in threading.enumerate():
            if thread.daemon and thread is not threading.current_thread():
                # Python also lists threads of Zenoh, which it cannot join.
                with suppress(AssertionError, RuntimeError):
                    thread.join(max(0.0, deadline - time.monotonic()))

    def _release(self) -> None:
        """Close the graph watcher, the session and the library logs."""
        atexit.unregister(self._end_with_program)
        with self._lock:
            self._initialized = False
            session, self._session = self._session, None
            self._shared_subscribers = None
            watcher, self._watcher = self._watcher, None
            library_logs, self._library_logs = self._library_logs, None
            self._on_graph_change = []
        if watcher is not None:
            watcher.close()
        if session is not None:
            from teleopctl.wire import close_session

            close_session(session)
        if library_logs is not None:
            library_logs.close()

    def end_by_signal(self) -> None:
        """Mark the context as ended by a signal, and call its shutdown callbacks in a new thread.

        The spinning thread then destroys the nodes and shuts down. The callbacks take locks that
        the interrupted thread may hold, hence the new thread.
        """
        self._ended_by_signal = True
        self._running = False
        _thread.start_new_thread(self._notify_shutdown, ())

    def _notify_shutdown(self) -> None:
        with self._lock:
            callbacks, self._on_shutdown = self._on_shutdown, []
        for callback in callbacks:
            callback()
        with self._graph_changed:
            self._graph_changed.notify_all()

    def __enter__(self) -> Context:
        if not self._running:
            self.init()
        return self

    def __exit__(self, *_: object) -> None:
        self.try_shutdown()
