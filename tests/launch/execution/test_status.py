"""What a launch writes down about its processes."""

from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.base.background import StartTime
from teleopctl.launch.execution.status import status_of
from teleopctl.launch.model.plan import ProcessPlan


@pytest.mark.parametrize(
    ("accompanies", "was_signalled", "ended_cleanly", "state"),
    [
        (False, False, True, "finished"),
        (False, True, True, "stopped"),
        (False, True, False, "died"),
        # The launch ends a recorder by a signal once all others have ended.
        (True, True, True, "finished"),
        (True, True, False, "died"),
    ],
)
def test_the_end_of_a_process_is_its_own_or_the_launchs(
    accompanies: bool, was_signalled: bool, ended_cleanly: bool, state: str
) -> None:
    child: Any = SimpleNamespace(
        plan=ProcessPlan(name="some-1", command=["some"], accompanies=accompanies),
        is_running=False,
        was_signalled=was_signalled,
        ended_cleanly=ended_cleanly,
        exit_status=0 if ended_cleanly else 1,
        pid=1,
        ended_at=0.0,
        log_file="some.log",
    )
    assert status_of(child, StartTime()).state == state
