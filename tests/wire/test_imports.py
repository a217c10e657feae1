import subprocess
import sys

import pytest

HEAVY = {"numpy", "rosbags", "yaml", "psutil", "platformdirs", "asyncio", "inspect", "subprocess"}


@pytest.mark.parametrize(
    "module", ["session", "graph", "router", "tokens", "keys", "qos", "attachment"]
)
def test_finding_the_router_and_reading_the_graph_load_nothing_heavy(module):
    program = f"import teleopctl.wire.{module}, sys; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    assert HEAVY.isdisjoint(loaded)
