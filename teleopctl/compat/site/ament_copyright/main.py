"""``ament_copyright.main``. Checks of copyright headers: skipped, with the reason."""

import sys
from collections.abc import Sequence

from ament_lint.checking import skip

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:  # noqa: ARG001 -- ament_copyright has it
    """Skip the running test: copyright headers are not checked here.

    Args:
        argv: Command line with files and folders, which is not used.

    Raises:
        UnavailableError: No test runs.
    """
    skip("copyright headers are not checked here; ament_copyright of ROS 2 checks them")


if __name__ == "__main__":
    sys.exit(main())
