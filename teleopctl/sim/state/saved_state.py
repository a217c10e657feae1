"""Saved states of a simulation, in memory or in files."""

from __future__ import annotations

import contextlib
import json
import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError, RefusedError
from teleopctl.sim.state.physics import part_names

if TYPE_CHECKING:
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]

_FORMAT = "teleopctl simulation state 1"
# Values that files of earlier versions lack.
_LATER = (
    *("sliding", "drives_inertia", "drives_tuned_at", "drives_speed_before"),
    *("drives_still", "asleep"),
)
# Limit of a file's size in bytes, a million numbers: far more than the state of any robot.
_LONGEST_FILE = 32_000_000


@dataclass(frozen=True)
class SavedState:
    """State of a simulation at one time, with the names of the model's parts.

    Attributes:
        parts: Names of the model's parts: a state fits only a model with the same parts.
        values: Values that `Simulation.save` returned.
        time_ns: Simulated time of the state, in nanoseconds; 0 in files of earlier versions.
    """

    parts: tuple[str, ...]
    values: Mapping[str, Array]
    time_ns: int = 0

    @classmethod
    def of(cls, simulation: Simulation) -> SavedState:
        """Return the present state of a simulation as `SavedState`."""
        return cls(_parts(simulation), simulation.save(), simulation.time_ns)

    @classmethod
    def read(cls, path: Path) -> SavedState:
        """Return the saved state in a file that `write` has written; raise for other files.

        Raises:
            InvalidFileError: The file cannot be read, or is no saved state.
        """
        if _plain_size(path) > _LONGEST_FILE:
            raise InvalidFileError(f"{path} is too large for a saved state")
        return cls.parse(read_text(path), str(path))

    @classmethod
    def parse(cls, text: str, source: str) -> SavedState:
        """Return the saved state in a text that `write` has written; raise for other texts.

        Args:
            text: Text of the file.
            source: Name of the source for error messages.

        Raises:
            InvalidFileError: The text is no saved state.
        """
        try:
            content = json.loads(text)
            if content["format"] != _FORMAT:
                raise ValueError
            values = {str(k): np.array(v, float).ravel() for k, v in content["values"].items()}
            return cls(tuple(map(str, content["parts"])), values, int(content.get("time_ns", 0)))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise InvalidFileError(f"{source} is not a state saved by the simulator") from error

    def text(self) -> str:
        """Return the text of the state, which `parse` reads."""
        content = {
            "format": _FORMAT,
            "time_ns": self.time_ns,
            "parts": self.parts,
            "values": {name: value.tolist() for name, value in self.values.items()},
        }
        return json.dumps(content)

    def write(self, path: Path) -> None:
        """Write the state to a file, replacing an existing one.

        Raises:
            InvalidFileError: The file cannot be written, or the path is not that of a plain file.
        """
        _plain_size(path)
        draft = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            draft.write_text(f"{self.text()}\n", "utf-8")
            draft.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                draft.unlink()
            raise InvalidFileError(f"Cannot write {path}: {error.strerror}") from error

    def put(self, simulation: Simulation, *, keeps_time: bool = False) -> None:
        """Set a simulation to this state; raise if its model does not have the same parts.

        Args:
            simulation: Simulation to set.
            keeps_time: Whether simulated time continues from that of the state, not from zero.

        Raises:
            RefusedError: The state is of another model, or invalid; nothing is changed.
        """
        here, there = _parts(simulation), self.parts
        if only := next((part for part in there if part not in here), ""):
            raise RefusedError(f"The state is of another model: it has the {only}")
        if only := next((part for part in here if part not in there), ""):
            raise RefusedError(f"The state is of another model: it lacks the {only}")
        now = simulation.save()
        values = {**{name: now[name] for name in _LATER}, **self.values}
        sizes, saved = ({k: v.size for k, v in one.items()} for one in (now, values))
        # The numbers of overlapping pairs and of pushes vary.
        for name in {"waiting", "pushes"} & saved.keys():
            saved[name] = sizes[name]
        if here != there or sizes != saved:
            raise RefusedError(
                "The state is of another model: the same parts have other properties"
            )
        if not all(np.isfinite(value).all() for value in self.values.values()):
            raise RefusedError("The saved state is invalid: not all of its numbers are finite")
        simulation.restore(values, self.time_ns if keeps_time else None)


def _plain_size(path: Path) -> int:
    """Return the size of a file in bytes; 0 if the file does not exist.

    Raises:
        InvalidFileError: The path is that of a folder or a device, which may have no end and must
            not be replaced, or is not accessible.
    """
    try:
        there = path.stat()
    except FileNotFoundError:
        return 0
    except OSError as error:
        raise InvalidFileError(f"Cannot open {path}: {error.strerror}") from error
    if not stat.S_ISREG(there.st_mode):
        raise InvalidFileError(f"{path} is not a regular file")
    return there.st_size


def _parts(simulation: Simulation) -> tuple[str, ...]:
    model = simulation.model
    pairs = (f"pair of '{one}' and '{two}'" for one, two in model.excluded)
    return (*part_names(model.mj_model), *pairs)
