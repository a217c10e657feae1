"""``python -m teleopctl.launch PLAN``: the supervisor of a launch in the background."""

import sys
from pathlib import Path

from teleopctl.launch.execution.supervisor import Supervisor
from teleopctl.launch.model.plan import load_plan
from teleopctl.output import outlive_output, take_log_file


def main() -> int:
    """Carry out the plan in the file that the command line names."""
    outlive_output(log_file=take_log_file())
    plan = load_plan(Path(sys.argv[1]).read_text(encoding="utf-8"))
    return Supervisor(plan, in_background=True).run()


if __name__ == "__main__":
    sys.exit(main())
