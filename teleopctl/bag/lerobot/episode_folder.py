"""Folder of recorded episodes: their bags, and the LeRobot data set that is made of them.

The bags are the truth: ``episodes/episode_000003.mcap`` is episode 3 of the data set beside it in
the same folder, and each says itself how it became one. An episode that is being recorded lies in
``episodes/.recording``, one that could not be used in ``episodes/rejected``, one that was dropped
in ``episodes/dropped``.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.editing.copying import OutputBag, copy_bags
from teleopctl.bag.lerobot.dataset import (
    DATA_FOLDERS,
    EpisodeNotes,
    EpisodeRow,
    LeRobotDataset,
)
from teleopctl.bag.lerobot.export import DRAFTS, LeRobotSummary, add_episode
from teleopctl.bag.lerobot.features import find_actions, find_cameras, find_hand
from teleopctl.bag.lerobot.folder_lock import FolderLock, locked
from teleopctl.bag.lerobot.sampling import LeRobotOptions
from teleopctl.bag.storage.bag import open_bag
from teleopctl.bag.verify.session import STATE_ATTACHMENT
from teleopctl.errors import (
    InvalidFileError,
    MissingExtraError,
    NotFoundError,
    RefusedError,
    SystemFailureError,
    TeleopctlError,
    UsageError,
)

EPISODE_RECORD = "teleopctl.episode"
"""Name of the metadata record of an episode's bag."""

_BAGS, _RECORDING, _REJECTED, _DROPPED = "episodes", ".recording", "rejected", "dropped"
# Longest wait for another program that changes the data set, in seconds.
_LONGEST_CHANGE_S = 120.0


class EpisodeSettings(NamedTuple):
    """Settings with which an episode was recorded and becomes part of a data set.

    Attributes:
        task: Description of the task in words.
        fps: Frames per second.
        robot: Type of the robot in one word; empty if unknown.
        state: Topic of the robot's state, or a field of a topic.
        action: Topics of the robot's commands, or fields; empty for those of all controllers.
        cameras: Image topics, each a topic or ``NAME=TOPIC``; empty for all colour images.
        hand: Topic of the operator's twists; empty for servo's.
        success: Whether the task succeeded; None if unknown.
        driven_by: Device or program that drove the robot; empty if unknown.
        seed: Seed of the places of the objects; None if they were not placed at random.
    """

    task: str = "teleoperation"
    fps: int = 30
    robot: str = ""
    state: str = "/joint_states"
    action: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    hand: str = ""
    success: bool | None = None
    driven_by: str = ""
    seed: int | None = None

    def record(self) -> dict[str, str]:
        """Return the metadata record of the bag, values as JSON."""
        return {name: json.dumps(value) for name, value in self._asdict().items()}

    @classmethod
    def of(cls, bag: Bag) -> EpisodeSettings:
        """Return the settings in a bag; the defaults if it was recorded by another program.

        Raises:
            InvalidFileError: The record is damaged.
        """
        found: Mapping[str, str] = dict(bag.records()).get(EPISODE_RECORD, {})
        try:
            values = {name: json.loads(text) for name, text in found.items()}
        except ValueError as error:
            raise InvalidFileError(f"{bag.path} has a damaged record of its episode") from error
        for name in ("action", "cameras"):
            values[name] = tuple(values.get(name, ()))
        return cls(**{name: value for name, value in values.items() if name in cls._fields})

    def options(self, bag: Bag) -> LeRobotOptions:
        """Return the options by which a bag becomes an episode; what is not set is found in it."""
        cameras = self.cameras or tuple(
            f"{name}={topic}" for name, topic in find_cameras(bag).items()
        )
        return LeRobotOptions(
            self.state,
            self.action or tuple(find_actions(bag)),
            cameras,
            self.fps,
            self.task,
            self.robot or None,
            self.hand or find_hand(bag) or "/servo_node/delta_twist_cmds",
        )


def episode_bags(path: Path) -> list[Path]:
    """Return the bags of the saved episodes of a folder; of a bag, the bag itself."""
    return _saved_bags(path) or [path]


def _saved_bags(folder: Path) -> list[Path]:
    return sorted((folder / _BAGS).glob("episode_*.mcap"))


class EpisodeFolder:
    """Folder with recorded episodes and their data set.

    Args:
        folder: Folder, which need not exist yet.

    Raises:
        InvalidFileError: The folder has a broken data set, or one of another version.
        MissingExtraError: pyarrow is not installed.

    Attributes:
        folder: The folder.
        dataset: Data set in the folder.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.dataset = LeRobotDataset(folder)
        self._recording: FolderLock | None = None

    @classmethod
    def existing(cls, folder: Path) -> EpisodeFolder:
        """Return a folder that has episodes.

        Raises:
            NotFoundError: The folder has neither bags nor a data set.
            InvalidFileError: The data set is broken, or of another version.
            MissingExtraError: pyarrow is not installed.
        """
        found = cls(folder)
        if folder.is_file():
            raise NotFoundError(f"'{folder}' is a file, not a folder with episodes")
        if not found.dataset.episodes and not found.bags():
            raise NotFoundError(
                f"'{folder}' has no episodes",
                hint=f"Record some: teleopctl episode record {folder} --task TEXT",
            )
        return found

    def bag(self, number: int) -> Path:
        """Return the path of the bag of an episode."""
        return self.folder / _BAGS / f"episode_{number:06d}.mcap"

    def bags(self) -> list[Path]:
        """Return the bags of all saved episodes in their order."""
        return _saved_bags(self.folder)

    def existing_bag(self, number: int) -> Path:
        """Return the path of the bag of an episode that exists.

        Raises:
            NotFoundError: There is no such bag.
        """
        bag = self.bag(number)
        if not bag.exists():
            has = [path.stem.removeprefix("episode_").lstrip("0") or "0" for path in self.bags()]
            raise NotFoundError(
                f"{self.folder} has no bag of an episode {number}",
                hint=f"It has {', '.join(has)}." if has else "It has no bags.",
            )
        return bag

    @property
    def next_number(self) -> int:
        """Number of the next episode."""
        last = max((int(path.stem.removeprefix("episode_")) for path in self.bags()), default=-1)
        return max(last + 1, len(self.dataset.episodes))

    # --- recording ------------------------------------------------------------------------

    def begin_recording(self) -> None:
        """Make the folder ready for a recorder, which has it alone until `end_recording`.

        Raises:
            RefusedError: Another recorder uses it, or it has data of another program.
            SystemFailureError: No files can be written there.
        """
        if not self.dataset.features and not self.bags():
            for name in DATA_FOLDERS:
                if (self.folder / name).exists():
                    raise RefusedError(
                        f"{self.folder / name} is of another program, and a data set would be "
                        "written there",
                        hint="Record into another folder.",
                    )
        drafts = self.folder / _BAGS / _RECORDING
        try:
            drafts.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=drafts):
                pass
        except OSError as error:
            raise SystemFailureError(
                f"Cannot record into {self.folder}: {error.strerror}",
                hint="Name another folder, in which this user may write.",
            ) from error
        busy = RefusedError(
            f"Another recorder records into {self.folder}",
            hint="Stop it (`teleopctl ps` shows what runs), or record into another folder.",
        )
        self._recording = FolderLock(drafts, busy)

    def end_recording(self) -> None:
        """Let other recorders use the folder; one in which nothing was recorded is removed."""
        if self._recording is not None:
            drafts = self.folder / _BAGS / _RECORDING
            for folder in (drafts, drafts.parent, self.folder):
                with contextlib.suppress(OSError):  # not empty
                    folder.rmdir()
            self._recording.release()

    def draft(self, number: int) -> Path:
        """Return the folder in which the bag of an episode is recorded, which does not exist yet.

        One of an earlier recorder that was killed is kept beside it.
        """
        wanted = self.draft_of(number)
        if wanted in self.unfinished():
            wanted.rename(_free(wanted))
        else:
            self.discard(number)
        return wanted

    def draft_of(self, number: int) -> Path:
        """Return the folder in which the bag of an episode is being recorded."""
        return self.folder / _BAGS / _RECORDING / f"episode_{number:06d}"

    def discard(self, number: int) -> None:
        """Remove the bag of an episode that is not to be kept."""
        shutil.rmtree(self.draft_of(number), ignore_errors=True)

    def unfinished(self) -> list[Path]:
        """Return the bags of episodes that were neither saved nor discarded."""
        drafts = (self.folder / _BAGS / _RECORDING).glob("episode_*")
        # A recorder that was killed just after it saved leaves an empty folder.
        return sorted(draft for draft in drafts if next(draft.glob("*.mcap"), None))

    def keep(self, draft: Path, number: int) -> Path:
        """Move a finished bag into its place as the bag of an episode; return its path.

        Raises:
            SystemFailureError: The file cannot be moved.
        """
        try:
            (file,) = draft.glob("*.mcap")
            kept = file.replace(self.bag(number))
            shutil.rmtree(draft)
        except (OSError, ValueError) as error:
            raise SystemFailureError(f"Cannot save {draft}: {error}") from error
        return kept

    def reject(self, bag: Path) -> Path:
        """Put the bag of an episode that cannot be used aside; return its new path."""
        aside = self.folder / _BAGS / _REJECTED
        aside.mkdir(parents=True, exist_ok=True)
        return bag.rename(_free(aside / bag.name))

    def missing(self) -> list[int]:
        """Return the numbers of the saved episodes that are not in the data set yet."""
        numbers = [int(path.stem.removeprefix("episode_")) for path in self.bags()]
        return [number for number in numbers if number >= len(self.dataset.episodes)]

    def add_missing(self, on_added: Callable[[int, LeRobotSummary], object]) -> list[str]:
        """Add all saved episodes to the data set; return why episodes were rejected.

        Args:
            on_added: Called with number and summary of each added episode.

        Raises:
            SystemFailureError: A file cannot be written.
            MissingExtraError: pyarrow or PyAV is not installed.
            RefusedError: Another program changes the data set all the time.
        """
        rejected = []
        with self._changing():
            for number in self.missing():
                bag = self.bag(number)
                wanted = len(self.dataset.episodes)
                if wanted != number:
                    bag = bag.rename(self.bag(wanted))
                try:
                    on_added(wanted, self._add(bag))
                except (SystemFailureError, MissingExtraError):
                    raise
                except TeleopctlError as error:
                    rejected.append(f"{error.message}: see {self.reject(bag)}")
        return rejected

    @contextlib.contextmanager
    def _changing(self) -> Iterator[None]:
        """Return a context manager in which no other program changes bags and data set."""
        busy = RefusedError(
            f"Another program is changing the data set in {self.folder}",
            hint="Try again once it has ended.",
        )
        with locked(self.folder, busy, _LONGEST_CHANGE_S):
            self.dataset = LeRobotDataset(self.folder)
            # Of a program that was killed.
            for left in self.folder.glob(f"{DRAFTS}*"):
                shutil.rmtree(left, ignore_errors=True)
            yield

    def rows(self) -> list[EpisodeRow]:
        """Return the episodes of the data set in their order."""
        return self.dataset.episodes

    def drop(self, numbers: Sequence[int]) -> list[Path]:
        """Remove episodes from the data set, and put their bags aside; return the bags' new paths.

        Later episodes get the numbers.

        Raises:
            NotFoundError: There is no such episode.
            RefusedError: No episode would remain, or the data set is lerobot's own.
        """
        with self._changing():
            return self._drop(numbers)

    def _drop(self, numbers: Sequence[int]) -> list[Path]:
        count = len(self.dataset.episodes)
        self.dataset.remove(numbers)
        aside = self.folder / _BAGS / _DROPPED
        moved = []
        for number in sorted(set(numbers)):
            if (bag := self.bag(number)).exists():
                aside.mkdir(parents=True, exist_ok=True)
                moved.append(bag.rename(_free(aside / bag.name)))
        kept = [number for number in range(count) if number not in set(numbers)]
        for new, old in enumerate(kept):
            if new != old and self.bag(old).exists():
                self.bag(old).rename(self.bag(new))
        return moved

    def trim(
        self,
        number: int,
        start_s: float | None,
        end_s: float | None,
        state_since: Callable[[Path, int], bytes] = lambda *_: b"",
    ) -> LeRobotSummary:
        """Cut an episode to a part of its time, in the data set and in its bag.

        The whole bag is put aside.

        Args:
            number: Number of the episode.
            start_s: Time of the first message to keep, in seconds from the start of the bag.
            end_s: Time at which the episode ends, in seconds from the start of the bag.
            state_since: Returns the state of the recorded simulation of a bag from which its
                messages since a time of recording, in nanoseconds, follow; ``b""`` without one.

        Raises:
            NotFoundError: There is no such episode, or nothing remains of it.
            UsageError: The end is not after the start.
            RefusedError: The data set is lerobot's own.
            SystemFailureError: A file cannot be written.
        """
        with self._changing():
            return self._trim(number, start_s, end_s, state_since)

    def _trim(
        self,
        number: int,
        start_s: float | None,
        end_s: float | None,
        state_since: Callable[[Path, int], bytes],
    ) -> LeRobotSummary:
        self.dataset.require(number)
        path = self.existing_bag(number)
        draft = self.draft(number)
        with open_bag(path) as bag:
            first_ns = bag.metadata.start_ns
            length_s = (bag.metadata.end_ns - first_ns) * 1e-9
            start_s, end_s = start_s or 0.0, length_s if end_s is None else end_s
            if start_s < 0.0:
                raise UsageError(f"The start, {start_s:g} s, is before that of episode {number}")
            if not start_s < end_s:
                raise UsageError(
                    f"The end, {end_s:g} s, is not after the start, {start_s:g} s",
                    hint=f"Episode {number} is {length_s:.1f} s long.",
                )
            start_ns = first_ns + round(start_s * 1e9)
            state = state_since(path, start_ns) if start_s else None
            cut = OutputBag(
                draft,
                start_ns=start_ns,
                end_ns=first_ns + round(end_s * 1e9) + 1,
                continues_latched=True,
                replaced={} if state is None else {STATE_ATTACHMENT: state},
            )
            copy_bags([bag], [cut])
        try:
            summary = self._add(draft, number)
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            raise
        aside = self.folder / _BAGS / _DROPPED
        aside.mkdir(parents=True, exist_ok=True)
        path.rename(_free(aside / path.name))
        self.keep(draft, number)
        return summary

    def _add(self, path: Path, number: int | None = None) -> LeRobotSummary:
        with open_bag(path) as bag:
            settings = EpisodeSettings.of(bag)
            notes = EpisodeNotes(settings.success, settings.driven_by)
            return add_episode(bag, self.dataset, settings.options(bag), notes, index=number)


def _free(path: Path) -> Path:
    """Return a path that does not exist: the path, or one with a number."""
    number, free = 2, path
    while free.exists():
        free, number = path.with_name(f"{path.stem}_{number}{path.suffix}"), number + 1
    return free
