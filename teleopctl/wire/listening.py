"""A subscriber to liveliness tokens whose callback runs on a thread of its own."""

import threading
from collections.abc import Callable

import zenoh

# What is left to the thread is one token's work, unless that waits for whoever undeclares.
_LONGEST_END_S = 2.0


class ListeningThread:
    """Has a function hear of tokens on a thread of its own, which ends with the subscriber.

    That a peer goes is told by the one thread which also ends what an advanced publisher does
    beside; its `undeclare` waits for that up to 10 s, and holds Python's lock meanwhile. So no
    Python may run there.

    No program waits for the thread at its end, but one that closes the session in order must not
    end before it: up to version 3.13 Python unwinds a thread that wants its lock meanwhile, and
    where that thread is in Zenoh's code the process aborts ("FATAL: exception not rethrown").

    Args:
        session: Where to listen.
        key: Of the tokens, those that are there already among them.
        hear: Called with each sample.
    """

    def __init__(
        self, session: zenoh.Session, key: str, hear: Callable[[zenoh.Sample], None]
    ) -> None:
        self._hear = hear
        self._thread: threading.Thread | None = None
        self._is_over = threading.Event()
        self._subscriber: zenoh.Subscriber[None] | None = None
        self._failure: zenoh.ZError | None = None
        # The thread that Zenoh starts for the callback inherits from the one that declares
        # whether a program waits for it at its end.
        declaring = threading.Thread(target=self._declare, args=(session, key), daemon=True)
        declaring.start()
        try:
            declaring.join()
        except BaseException:
            # Ctrl-C: nobody will know of the subscriber.
            declaring.join()
            self.undeclare()
            raise
        if self._failure is not None:
            raise self._failure

    def undeclare(self) -> None:
        """Hear no more; the thread has ended then, unless it is the one that calls this."""
        if self._subscriber is None:
            return
        self._subscriber.undeclare()
        if self._thread is threading.current_thread():
            return
        if self._is_over.wait(_LONGEST_END_S) and self._thread is not None:
            self._thread.join(_LONGEST_END_S)

    def _declare(self, session: zenoh.Session, key: str) -> None:
        callback = zenoh.handlers.Callback(self._hear_one, self._end)
        try:
            self._subscriber = session.liveliness().declare_subscriber(key, callback, history=True)
        except zenoh.ZError as error:
            self._failure = error

    def _hear_one(self, sample: zenoh.Sample) -> None:
        self._thread = threading.current_thread()
        self._hear(sample)

    def _end(self) -> None:
        """Be told by Zenoh, on the thread, that it lets go of the callback."""
        self._thread = threading.current_thread()
        self._is_over.set()
