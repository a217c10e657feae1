"""Transforms of one frame to its parent over time.

Times are integers in nanoseconds.
"""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass

from teleopctl.interfaces import to_seconds
from teleopctl.tf.errors import ExtrapolationException
from teleopctl.tf.transforms import Transform, interpolate


@dataclass(frozen=True, slots=True)
class TransformSample:
    """Transform of a frame to its parent at one time (stamp in nanoseconds)."""

    stamp: int
    parent: str
    transform: Transform


class StaticHistory:
    """Transform of a static frame, valid for all times."""

    def __init__(self, sample: TransformSample) -> None:
        self._sample = sample

    @property
    def is_static(self) -> bool:
        """Whether the frame is static: True."""
        return True

    @property
    def latest(self) -> TransformSample:
        """Sample with the static transform."""
        return self._sample

    @property
    def stamps(self) -> list[int]:
        """Stamps of the samples: always empty, since a static transform holds for all times."""
        return []

    def insert(self, sample: TransformSample) -> bool:
        """Replace the static transform by a new one; always return True."""
        self._sample = sample
        return True

    def at(self, stamp: int) -> TransformSample:  # noqa: ARG002 -- signature of MovingHistory.at
        """Return the sample of the static transform, whatever the time."""
        return self._sample


class MovingHistory:
    """Transforms of a moving frame over the last seconds, interpolated between samples.

    Args:
        length: Time before the newest sample for which samples are kept, in nanoseconds.
    """

    def __init__(self, length: int) -> None:
        self._length = length
        self._stamps: list[int] = []
        self._samples: list[TransformSample] = []

    @property
    def is_static(self) -> bool:
        """Whether the frame is static: False."""
        return False

    @property
    def latest(self) -> TransformSample:
        """Newest sample of the moving frame."""
        return self._samples[-1]

    @property
    def stamps(self) -> list[int]:
        """Stamps of the samples in nanoseconds, oldest first."""
        return self._stamps

    def insert(self, sample: TransformSample) -> bool:
        """Add a sample, now and then drop expired ones; return False if the sample is too old.

        A sample replaces an earlier one with the same stamp.
        """
        stamps, samples = self._stamps, self._samples
        if not stamps or sample.stamp > stamps[-1]:
            stamps.append(sample.stamp)
            samples.append(sample)
            # cut in blocks, so that a steady stream does not move the whole list each time
            expired = bisect_left(stamps, sample.stamp - self._length)
            if expired > len(stamps) // 4:
                del stamps[:expired], samples[:expired]
            return True
        if sample.stamp < stamps[-1] - self._length:
            return False
        index = bisect_left(stamps, sample.stamp)
        if stamps[index] == sample.stamp:
            samples[index] = sample
        else:
            stamps.insert(index, sample.stamp)
            samples.insert(index, sample)
        return True

    def at(self, stamp: int) -> TransformSample:
        """Return the sample at a time, interpolated; raise if the time is outside of the samples.

        Raises:
            ExtrapolationException: The time lies before or after all samples.
        """
        stamps = self._stamps
        index = bisect_right(stamps, stamp)
        if index and stamps[index - 1] == stamp:
            return self._samples[index - 1]
        if len(stamps) == 1:
            raise ExtrapolationException(
                f"Lookup would require extrapolation at time {seconds(stamp)}, "
                f"but only time {seconds(stamps[0])} is in the buffer"
            )
        if index == len(stamps):
            raise ExtrapolationException(
                "Lookup would require extrapolation into the future.  Requested time "
                f"{seconds(stamp)} but the latest data is at time {seconds(stamps[-1])}"
            )
        if index == 0:
            raise ExtrapolationException(
                "Lookup would require extrapolation into the past.  Requested time "
                f"{seconds(stamp)} but the earliest data is at time {seconds(stamps[0])}"
            )
        before, after = self._samples[index - 1], self._samples[index]
        if before.parent != after.parent:
            # the frame changed its parent between the samples: nothing to interpolate
            return TransformSample(stamp, before.parent, before.transform)
        fraction = (stamp - before.stamp) / (after.stamp - before.stamp)
        return TransformSample(
            stamp, before.parent, interpolate(before.transform, after.transform, fraction)
        )


def seconds(stamp: int) -> str:
    """Return a time in nanoseconds as tf2 prints it: seconds with six decimals."""
    return f"{to_seconds(stamp):f}"
