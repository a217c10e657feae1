"""Export of bags to a LeRobot data set, one episode each."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.export.output_folder import make_output_folder, removed_on_error
from teleopctl.bag.lerobot.dataset import EpisodeNotes, LeRobotDataset
from teleopctl.bag.lerobot.features import STAMPS
from teleopctl.bag.lerobot.sampling import LeRobotOptions, sample_episode
from teleopctl.errors import NotFoundError, SystemFailureError

DRAFTS = ".adding."
"""Beginning of the names of folders in which files of a new episode are written."""


class LeRobotSummary(NamedTuple):
    """Result of an export: episode, frames, element names, times and unusable messages.

    Attributes:
        frames: Number of frames of the episode.
        names: Names of the elements of each feature.
        left_out: Number of messages that could not be used, by topic.
        number: Number of the episode in the data set.
        by_stamps: Whether times are the stamps of the messages, not those of the recording.
        worst_offset_s: Largest age of a value in a frame, in seconds.
        worst_feature: Feature with this value.
        cameras: Features that are pictures.
        silent_s: Age in seconds of the oldest value of the state and of each camera, where it is
            so great that the topic was silent.
    """

    frames: int
    names: dict[str, tuple[str, ...]]
    left_out: Mapping[str, int]
    number: int = 0
    by_stamps: bool = False
    worst_offset_s: float = 0.0
    worst_feature: str = ""
    cameras: tuple[str, ...] = ()
    silent_s: Mapping[str, float] = {}


def export_lerobot(
    bags: Iterable[Bag],
    folder: Path,
    options: Callable[[Bag], tuple[LeRobotOptions, EpisodeNotes]],
) -> list[LeRobotSummary]:
    """Export bags as a LeRobot data set, an episode each; return summaries of the episodes.

    Args:
        bags: Bags to export, each of which is used before the next one is taken.
        folder: Folder of the data set, created if missing.
        options: Function that returns topics, frame rate and task of a bag, and notes on it.

    Raises:
        NotFoundError: A topic does not exist, or has no usable message.
        UsageError: A camera topic has no images, a topic has no default field, or the frame rate is
            not between 1 and 1000.
        InvalidMessageError: A topic cannot be decoded.
        MissingExtraError: pyarrow or PyAV is not installed.
        RefusedError: The folder is not empty, or an episode has other features than the first.
        SystemFailureError: A file cannot be written.
        InvalidFileError: The bag is broken, or a gap between its times is too long.
    """
    make_output_folder(folder)
    with removed_on_error((folder,)):
        dataset = LeRobotDataset(folder)
        summaries = [add_episode(bag, dataset, *options(bag)) for bag in bags]
        if not summaries:
            raise NotFoundError("There is no episode to export")
        return summaries


def add_episode(
    bag: Bag,
    dataset: LeRobotDataset,
    options: LeRobotOptions,
    notes: EpisodeNotes | None = None,
    *,
    index: int | None = None,
) -> LeRobotSummary:
    """Add a bag to a data set as an episode; return a summary. After an error, nothing is added.

    Args:
        bag: Bag to add.
        dataset: Data set.
        options: Topics, frame rate and task.
        notes: Notes on the episode; its worst offset is measured.
        index: Index of the episode to replace; None to add one.

    Raises:
        NotFoundError: A topic does not exist, or has no usable message.
        UsageError: A camera topic has no images, a topic has no default field, or the frame rate is
            not between 1 and 1000.
        InvalidMessageError: A topic cannot be decoded.
        MissingExtraError: PyAV is not installed.
        RefusedError: The episode does not fit into the data set.
        SystemFailureError: A file cannot be written.
        InvalidFileError: The bag is broken, or a gap between its times is too long.
    """
    try:
        dataset.folder.mkdir(parents=True, exist_ok=True)
        # In the folder of the data set, so that a video can be moved at once.
        drafts = Path(tempfile.mkdtemp(prefix=DRAFTS, dir=dataset.folder))
        try:
            sampled = sample_episode(bag, options, drafts)
            episode = sampled.episode
            videos = {key: drafts / f"{key}.mp4" for key in episode.videos}
            notes = (notes or EpisodeNotes())._replace(worst_offset_s=sampled.worst_offset_s)
            index = dataset.add(episode, videos, notes, index=index)
        finally:
            shutil.rmtree(drafts, ignore_errors=True)
    except OSError as error:
        raise SystemFailureError(
            f"Cannot write to {dataset.folder}: {error.strerror or error}"
        ) from error
    names = {key: tuple(each) for key, each in episode.names.items() if key != STAMPS}
    return LeRobotSummary(
        episode.length,
        names,
        sampled.left_out,
        index,
        sampled.by_stamps,
        sampled.worst_offset_s,
        sampled.worst_feature,
        tuple(episode.videos),
        sampled.silent_s,
    )
