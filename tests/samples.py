"""Which of many cases a run tries: a part by default, all with ``--hypothesis-profile=nightly``."""

from collections.abc import Sequence
from typing import TypeVar

from hypothesis import settings

Case = TypeVar("Case")


def is_nightly() -> bool:
    """Whether this run has the time for every case."""
    return settings.get_current_profile_name() == "nightly"


def sample(cases: Sequence[Case], one_of: int) -> Sequence[Case]:
    """One of so many cases, the same each time; all of them nightly."""
    return cases if is_nightly() else cases[::one_of]
