"""A bag in front of a player's head: what comes next, and sending it."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.bag.player.clock_output import ClockOutput
from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.outputs import Outputs
from teleopctl.bag.player.read_ahead import ReadAhead, by_sent_time
from teleopctl.bag.player.source import Source
from teleopctl.bag.player.time_line import TimeLine
from teleopctl.bag.records import BagMessage


class MessageCursor:
    """Cursor over the messages of bags, in time order; used by one thread.

    Args:
        source: The bags.
        line: The playback time, which jumps with the tape.
        outputs: Where messages are sent.
        clock: Publishes the time with them.
        options: In which order they come, and how many are read ahead.
        told: Called with a sentence for each part that is broken.
        played: Called with each message that was sent.

    Attributes:
        until_ns: Time of the last message that may come, in nanoseconds since the epoch; -1 for
            all.
        position_ns: Time of the last message that was sent, or of the jump after it.
    """

    def __init__(
        self,
        source: Source,
        line: TimeLine,
        outputs: Outputs,
        clock: ClockOutput,
        options: PlayOptions,
        told: Callable[[str], object],
        played: Callable[[BagMessage], object],
    ) -> None:
        self._source = source
        self._line = line
        self._outputs = outputs
        self._clock = clock
        self._is_by_sent_time = options.message_order == "sent"
        self._read_ahead = options.read_ahead
        self._told = told
        self._played = played
        self._queue: ReadAhead | None = None
        self.until_ns = -1
        self.position_ns = line.now_ns()

    def jump_to(self, time_ns: int, read_ahead_s: float = 0.0) -> None:
        """Jump to a time, and publish what latched topics had then.

        Args:
            time_ns: In nanoseconds since the epoch.
            read_ahead_s: How long the first messages may take to be read before the time runs.
        """
        self.close()
        # Before anything else reads the files.
        latched = self._source.latched_before(self._outputs.topics, time_ns)
        messages = self._source.messages(self._outputs.topics, time_ns, self._told)
        if self._is_by_sent_time:
            messages = by_sent_time(messages, self._read_ahead)
        self._queue = ReadAhead(messages, self._line.wake, self._read_ahead)
        if read_ahead_s:
            self._queue.wait_until_filled(read_ahead_s)
        self.position_ns = time_ns
        self._line.jump(time_ns)
        self._clock.publish()
        for message in latched:
            self._send(message)

    def next(self) -> tuple[BagMessage | None, bool]:
        """Return the next message without removing it, and whether no more will come.

        Raises:
            TeleopctlError: The bag could not be read any further.
        """
        assert self._queue is not None
        message = self._queue.first()
        if message is None:
            return None, self._queue.has_ended
        if 0 <= self.until_ns < self.time_of(message):
            return None, True
        return message, False

    def send_next(self, message: BagMessage) -> bool:
        """Publish the next message; return False if it is not played."""
        assert self._queue is not None
        self._queue.drop_first()
        time_ns = self.time_of(message)
        for split in self._source.splits_between(self.position_ns, time_ns):
            self._outputs.tell_of_split(split)
        self.position_ns = time_ns
        return self._send(message)

    def time_of(self, message: BagMessage) -> int:
        """Return the time at which a message is due, in nanoseconds since the epoch."""
        return message.publish_time_ns if self._is_by_sent_time else message.log_time_ns

    def close(self) -> None:
        """Stop reading."""
        if self._queue is not None:
            self._queue.close()
            self._queue = None

    def _send(self, message: BagMessage) -> bool:
        self._clock.before(message.topic)
        is_sent = self._outputs.send(message)
        if is_sent:
            self._played(message)
        return is_sent
