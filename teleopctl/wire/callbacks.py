"""Callbacks that Zenoh calls on its own threads."""

from __future__ import annotations

from _thread import _local as local  # threading has more, which takes 5 ms to import

import zenoh

from teleopctl.base.interrupts import transport_callback
from teleopctl.base.typed import Callable, TypeVar

_Item = TypeVar("_Item")

# Calls after which the import of ctypes, 2 ms, is worthwhile; few commands receive as many.
_FEW_CALLS = 20

_first_calls = iter(range(_FEW_CALLS))
_state = local()


def direct_callback(
    on_item: Callable[[_Item], object], on_end: Callable[[], object] | None = None
) -> zenoh.handlers.Callback[_Item]:
    """Return a Zenoh handler that calls `on_item` on Zenoh's threads, and `on_end` at the end.

    By default CPython treats each call as one from a new thread: it creates a thread state, with a
    stack that is mapped and unmapped, and deletes it afterwards, which takes longer than to receive
    a message (CPython's issue 146219). So the state is kept, as CPython's manual describes for
    threads that call often.

    Args:
        on_item: Called with each sample, query or reply. It must be short and must not wait, since
            it delays other callbacks, and must not raise.
        on_end: Called after the last item.
    """

    @transport_callback
    def call(item: _Item) -> None:
        try:
            _state.is_kept  # noqa: B018 -- deleted together with the thread state
        except AttributeError:
            if next(_first_calls, None) is None:
                _keep_state()
        on_item(item)

    return zenoh.handlers.Callback(call, on_end, indirect=False)


def _keep_state() -> None:
    """Keep Python's state of this thread; about 20 kB leak when the thread ends."""
    import ctypes

    # Not released, so that Zenoh's calls are nested in this one: the end of the outermost call
    # deletes the state.
    ctypes.pythonapi.PyGILState_Ensure()
    _state.is_kept = True
