"""Live view of the ROS graph of a domain, updated as liveliness tokens come and go."""

import threading
from collections import deque
from collections.abc import Callable

import zenoh

from teleopctl.wire.callbacks import direct_callback
from teleopctl.wire.graph import MOST_TOKENS, Graph, node_key
from teleopctl.wire.invalid_messages import InvalidMessageCounter
from teleopctl.wire.keys import liveliness_key
from teleopctl.wire.session import domain_id
from teleopctl.wire.tokens import EndpointToken, EntityKind, NodeToken, parse_token

_LONGEST_REPORTED = 200

# Longest wait for the listening thread, which processes at most one more token, unless its callback
# waits for the thread that undeclares.
_LONGEST_END_S = 2.0

# The router may also report a session's own tokens, even after they were undeclared. So many of the
# last undeclared tokens are not added again.
_MOST_GONE = 256


class GraphWatcher:
    """Live view of the ROS graph of a domain; thread-safe.

    Tokens that the session itself has declared before are unknown until `add_own_token`.

    Args:
        session: Session of the liveliness subscriptions; it stays open when the watcher closes.
        domain: ROS domain, by default that of ``ROS_DOMAIN_ID``.
        on_change: Called without arguments after each change, on a thread of Zenoh: it must be
            quick and must not raise.

    Attributes:
        refusals: Counter of the tokens that are malformed or too many.
    """

    def __init__(
        self,
        session: zenoh.Session,
        domain: int | None = None,
        on_change: Callable[[], None] | None = None,
    ) -> None:
        self._changed = threading.Condition()
        self._tokens: dict[str, NodeToken | EndpointToken] = {}
        # Endpoint tokens by kind and name, so that a look-up after a change need not build a graph.
        self._by_name: dict[tuple[EntityKind, str], dict[str, EndpointToken]] = {}
        self._graph: Graph | None = None
        self._closed = False
        self._on_change = on_change
        self.refusals = InvalidMessageCounter("a token of the graph", _report)
        domain = domain_id() if domain is None else domain
        self._own_zid = str(session.zid())
        self._own_gone: deque[str] = deque(maxlen=_MOST_GONE)
        self._subscribers = (
            # Tokens that the session declares from now on are delivered before their declaration
            # returns. Without history, since Zenoh would deliver that on the thread on which no
            # Python may run; see `ListeningThread`.
            session.liveliness().declare_subscriber(
                liveliness_key(domain, self._own_zid), direct_callback(self._receive_own)
            ),
            ListeningThread(session, liveliness_key(domain), self._receive),
        )

    def snapshot(self) -> Graph:
        """Return the present ROS graph as an immutable snapshot."""
        with self._changed:
            return self._snapshot()

    def matching(
        self, kind: EntityKind, name: str, type_name: str | None = None
    ) -> list[EndpointToken]:
        """Return the present endpoints of a kind and topic or service name, optionally of one type.

        The required time does not depend on the size of the graph, not even after a change.
        """
        with self._changed:
            found = self._by_name.get((kind, name), {}).values()
            return [e for e in found if type_name is None or e.type_name == type_name]

    def wait_for(
        self, predicate: Callable[[Graph], object], timeout_s: float | None = None
    ) -> bool:
        """Wait until the graph satisfies a predicate; return False on timeout or if closed.

        Args:
            predicate: Function called with a snapshot at once and after each change; it returns
                whether the wait ends.
            timeout_s: Longest wait in seconds; None waits forever.
        """
        with self._changed:
            satisfied = self._changed.wait_for(
                lambda: self._closed or predicate(self._snapshot()), timeout_s
            )
            return not self._closed and bool(satisfied)

    def add_own_token(self, text: str) -> None:
        """Add a token that this watcher's session has declared, without waiting for Zenoh."""
        token = parse_token(text)
        with self._changed:
            if token is None or text in self._own_gone or text in self._tokens:
                return
            self._add(text, token)
        self._notify_change()

    def remove_own_token(self, text: str) -> None:
        """Remove a token that this watcher's session has undeclared, without waiting for Zenoh.

        Zenoh reports the removal later if the router has also reported that token to the session.
        """
        with self._changed:
            self._own_gone.append(text)
            if text not in self._tokens:
                return
            self._remove(text, self._tokens[text])
        self._notify_change()

    def close(self) -> None:
        """Unsubscribe from liveliness changes, and wake threads that wait for the graph.

        Closing twice does no harm.
        """
        with self._changed:
            if self._closed:
                return
            self._closed = True
            self._changed.notify_all()
        # Not under the lock: a callback may be waiting for it.
        for subscriber in self._subscribers:
            subscriber.undeclare()

    def _snapshot(self) -> Graph:
        if self._graph is None:
            self._graph = Graph(self._tokens.values())
        return self._graph

    def _receive(self, sample: zenoh.Sample) -> None:
        text = str(sample.key_expr)
        token = parse_token(text)
        if token is None:
            self.refusals.refuse(f"{text[:_LONGEST_REPORTED]!r} cannot be read")
        elif token.zid != self._own_zid:
            self._note(sample, text, token)

    def _receive_own(self, sample: zenoh.Sample) -> None:
        text = str(sample.key_expr)
        token = parse_token(text)
        if token is not None:
            self._note(sample, text, token)

    def _note(self, sample: zenoh.Sample, text: str, token: NodeToken | EndpointToken) -> None:
        if len(self._tokens) >= MOST_TOKENS and text not in self._tokens:
            if sample.kind == zenoh.SampleKind.PUT:
                self.refusals.refuse(f"there are {MOST_TOKENS} already")
            return
        with self._changed:
            if sample.kind == zenoh.SampleKind.PUT:
                # No token is declared twice: a session numbers its nodes and endpoints.
                if text in self._own_gone:
                    return
                self._add(text, token)
            else:
                self._remove(text, token)
        self._notify_change()

    def _add(self, text: str, token: NodeToken | EndpointToken) -> None:
        self._tokens[text] = token
        if isinstance(token, EndpointToken):
            self._by_name.setdefault((token.kind, token.name), {})[text] = token
        self._graph = None
        self._changed.notify_all()

    def _remove(self, text: str, token: NodeToken | EndpointToken) -> None:
        self._forget(text)
        if isinstance(token, NodeToken):
            self._drop_endpoints(token)
        self._graph = None
        self._changed.notify_all()

    def _notify_change(self) -> None:
        if self._on_change is not None:
            self._on_change()

    def _drop_endpoints(self, node: NodeToken) -> None:
        """Remove the endpoints of a removed node; their own tokens may be undeclared later."""
        key = node_key(node)
        for text in [t for t, token in self._tokens.items() if node_key(token) == key]:
            self._forget(text)

    def _forget(self, text: str) -> None:
        token = self._tokens.pop(text, None)
        if isinstance(token, EndpointToken):
            named = self._by_name[token.kind, token.name]
            del named[text]
            if not named:
                del self._by_name[token.kind, token.name]


def _report(text: str) -> None:
    import logging

    logging.getLogger(__name__).warning("%s", text)


class ListeningThread:
    """Subscriber to liveliness changes that calls a function on a daemon thread of its own.

    Zenoh reports the end of a peer on the thread that also stops the background tasks of advanced
    publishers. Their `undeclare` waits for that thread up to 10 s while it holds the GIL. So no
    Python may run on that thread.

    The thread is a daemon, but a program that closes the session must not end before the thread: up
    to version 3.13 Python, while it exits, unwinds a thread that requests the GIL, and if that
    thread is in Zenoh's code the process aborts ("FATAL: exception not rethrown").

    Args:
        session: Session of the subscription.
        key: Key expression of the tokens; existing tokens are received too.
        on_sample: Called with each sample, on the thread.
    """

    def __init__(
        self, session: zenoh.Session, key: str, on_sample: Callable[[zenoh.Sample], None]
    ) -> None:
        self._on_sample = on_sample
        self._thread: threading.Thread | None = None
        self._is_over = threading.Event()
        self._subscriber: zenoh.Subscriber[None] | None = None
        self._failure: zenoh.ZError | None = None
        # The thread that Zenoh starts for the callback inherits the daemon flag of the declaring
        # thread.
        declaring = threading.Thread(target=self._declare, args=(session, key), daemon=True)
        declaring.start()
        try:
            declaring.join()
        except BaseException:
            # Ctrl-C: the caller gets no object to undeclare.
            declaring.join()
            self.undeclare()
            raise
        if self._failure is not None:
            raise self._failure

    def undeclare(self) -> None:
        """Undeclare the subscriber, and wait up to 4 s for the end of its thread."""
        if self._subscriber is None:
            return
        self._subscriber.undeclare()
        if self._thread is threading.current_thread():
            return
        if self._is_over.wait(_LONGEST_END_S) and self._thread is not None:
            self._thread.join(_LONGEST_END_S)

    def _declare(self, session: zenoh.Session, key: str) -> None:
        callback = zenoh.handlers.Callback(self._receive_one, self._end)
        try:
            self._subscriber = session.liveliness().declare_subscriber(key, callback, history=True)
        except zenoh.ZError as error:
            self._failure = error

    def _receive_one(self, sample: zenoh.Sample) -> None:
        self._thread = threading.current_thread()
        self._on_sample(sample)

    def _end(self) -> None:
        """Record the end of the callback; called by Zenoh on the thread."""
        self._thread = threading.current_thread()
        self._is_over.set()
