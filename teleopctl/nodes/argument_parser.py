"""Parser of an executable's arguments, whose mistakes are errors like those of the command line."""

import argparse
from typing import NoReturn

from teleopctl.errors import UsageError


class ArgumentParser(argparse.ArgumentParser):
    """`argparse.ArgumentParser` that raises a `UsageError` for a wrong argument."""

    def error(self, message: str) -> NoReturn:
        """Raise `UsageError` with ``message`` and the usage, instead of exiting the process."""
        raise UsageError(message, hint=self.format_usage().strip())
