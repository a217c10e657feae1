"""``launch.utilities.AsyncSafeSignalManager``: signals as calls in a loop."""

import asyncio
import signal

import pytest
from launch.utilities import AsyncSafeSignalManager


@pytest.fixture
def loop():
    loop = asyncio.new_event_loop()
    yield loop
    loop.close()


def turn(loop):
    """Run the loop once over what is ready."""
    loop.call_soon(loop.stop)
    loop.run_forever()


def test_functions_are_called_in_the_loop_within_the_context(loop):
    got: list[int] = []
    before: list[int] = []
    previous = signal.signal(signal.SIGINT, lambda signum, _frame: before.append(signum))
    try:
        manager = AsyncSafeSignalManager(loop)
        assert manager.handle(signal.SIGINT, got.append) is None
        with manager:
            signal.raise_signal(signal.SIGINT)
            assert got == []
            turn(loop)
            assert (got, before) == ([signal.SIGINT], [])
            assert manager.handle(signal.SIGINT, None) == got.append
            signal.raise_signal(signal.SIGINT)
            assert before == [signal.SIGINT]
            manager.handle(signal.SIGINT, got.append)
        signal.raise_signal(signal.SIGINT)
        turn(loop)
        assert (got, before) == ([signal.SIGINT], [signal.SIGINT] * 2)
    finally:
        signal.signal(signal.SIGINT, previous)
