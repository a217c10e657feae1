"""Sweeps: many runs of a launch file with varied parameters, each recorded to a bag.

May import `bag`, `compat`, `interfaces`, `launch` and `node`, and what every package may: `base`,
`errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.sweep.cluster.client import Cluster as Cluster
    from teleopctl.sweep.cluster.file_transfer import (
        not_sent as not_sent,
        pack_launch as pack_launch,
    )
    from teleopctl.sweep.measure import (
        Measure as Measure,
        measure_bag as measure_bag,
        parse_measure as parse_measure,
    )
    from teleopctl.sweep.one_run import (
        RunRequest as RunRequest,
        RunResult as RunResult,
        launch_arguments as launch_arguments,
    )
    from teleopctl.sweep.sweep import Sweep as Sweep
    from teleopctl.sweep.variation import (
        GridParameter as GridParameter,
        RandomParameter as RandomParameter,
        combinations as combinations,
        parse_grid as parse_grid,
        parse_sample as parse_sample,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
