"""``python -m teleopctl.launch REQUEST``: the supervisor of a launch in the background."""

import sys
from pathlib import Path

from teleopctl.errors import TeleopctlError
from teleopctl.launch.starting import run_in_background
from teleopctl.output import outlive_output, take_log_file


def main() -> int:
    """Launch what the file that the command line names asks for."""
    outlive_output(log_file=take_log_file())
    try:
        return run_in_background(Path(sys.argv[1]))
    except TeleopctlError as error:
        sys.stderr.write(f"[ERROR] [launch]: {error}\n")
        return error.exit_status


if __name__ == "__main__":
    sys.exit(main())
