"""``python -m teleopctl.launch REQUEST``: runs a launch request as a background process."""

import sys
from pathlib import Path

from teleopctl.base import interrupts
from teleopctl.base.output import outlive_output, take_log_file
from teleopctl.errors import EXIT_INTERRUPTED, TeleopctlError
from teleopctl.launch.execution.judgement import refusal_text
from teleopctl.launch.starting import run_in_background


def main() -> int:
    """Run the launch of the request file that the command line names; return the exit status."""
    try:
        interrupts.install_sigint_handler()
        outlive_output(log_file=take_log_file())
        return run_in_background(Path(sys.argv[1]))
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except TeleopctlError as error:
        sys.stderr.write(refusal_text(error))
        return error.exit_status
    except Exception as error:
        if interrupts.is_cause(error):
            return EXIT_INTERRUPTED
        raise


if __name__ == "__main__":
    sys.exit(main())
