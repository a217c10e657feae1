"""Sampling of test cases: a part by default, all with ``--hypothesis-profile=nightly``."""

from collections.abc import Iterable, Sequence
from typing import TypeVar

from hypothesis import settings

Case = TypeVar("Case")


def is_nightly() -> bool:
    """Return whether this run uses the nightly profile, which tries all cases."""
    return settings.get_current_profile_name() == "nightly"


def sample(cases: Iterable[Case], one_of: int) -> Sequence[Case]:
    """Return every ``one_of``-th case, the same in each run; all cases in a nightly run."""
    return [*cases][:: 1 if is_nightly() else one_of]
