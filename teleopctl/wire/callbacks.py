"""Callbacks that Zenoh calls on its own threads."""

from __future__ import annotations

import itertools
from _thread import _local as local  # threading has more, which takes 5 ms to import
from collections.abc import Callable

import zenoh

from teleopctl.base.interrupts import transport_callback
from teleopctl.base.typed import TypeVar

_Item = TypeVar("_Item")

# After so many calls the import of ctypes, 2 ms, is worth while; few commands are called as often.
_FEW_CALLS = 20

_calls = itertools.count(1)
_state = local()


def direct_callback(
    receive: Callable[[_Item], object], end: Callable[[], object] | None = None
) -> zenoh.handlers.Callback[_Item]:
    """Return a Zenoh handler that calls `receive` on Zenoh's thread, and `end` after the last item.

    To Python each call would be one by a new thread: it makes a state for it, with a stack that is
    mapped and unmapped, and forgets it afterwards, which takes longer than to receive a message
    (CPython's issue 146219). So the state is kept, as CPython's manual says for threads that call
    often.

    Args:
        receive: Called with each sample, query or reply. It must be short and must not wait, since
            it holds the others up, nor raise.
        end: Called when nothing more will come.
    """

    @transport_callback
    def call(item: _Item) -> None:
        try:
            _state.is_kept  # noqa: B018 -- an attribute of the state: gone with it
        except AttributeError:
            if next(_calls) > _FEW_CALLS:
                _keep_state()
        receive(item)

    return zenoh.handlers.Callback(call, end, indirect=False)


def _keep_state() -> None:
    """Keep what Python has of this thread; when the thread ends, some 20 kB are lost."""
    import ctypes

    # Not released: the call that Zenoh makes is then not the outermost one, whose end ends the
    # state.
    ctypes.pythonapi.PyGILState_Ensure()
    _state.is_kept = True
