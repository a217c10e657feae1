"""What becomes of saved episodes is told where the person who records sees it."""

import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.nodes.episodes.growth import DataSetGrowth

WARNING = "The data set cube has action, which the episode lacks: see cube/rejected/one.mcap"


@pytest.mark.parametrize(
    ("status", "output", "problem"), [(1, f"WARNING: {WARNING}\n", WARNING), (0, "", "")]
)
def test_why_an_episode_is_not_in_the_data_set(monkeypatch, status, output, problem):
    said: list[str] = []
    logger = SimpleNamespace(info=said.append, warning=said.append, error=said.append)
    node: Any = SimpleNamespace(get_logger=lambda: logger)
    done = subprocess.CompletedProcess([], status, "Added episode 1\n", output)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: done)
    growth = DataSetGrowth(node, lambda: None)
    growth._add(Path("cube"))
    assert growth.problem == problem
    assert said == ["Added episode 1", *filter(None, [problem])]
