"""``launch.invalid_launch_file_error``."""

from collections.abc import Sequence


class InvalidLaunchFileError(Exception):
    """Raised when a file is not a valid launch file.

    Args:
        extension: The ending of its name, where that is one of launch files.
        likely_errors: Errors of the parsers.
    """

    def __init__(
        self, extension: str = "", *, likely_errors: Sequence[BaseException] | None = None
    ) -> None:
        super().__init__(extension)
        self._extension = extension
        self._likely_errors = likely_errors
        if not extension or not likely_errors:
            self._text = "The launch file may have a syntax error, or its format is unknown"
            return
        count = "multiple exceptions" if len(likely_errors) > 1 else "exception"
        told = [f"\n - {type(error).__name__}: {error}" for error in likely_errors]
        self._text = f"Caught {count} when trying to load file of format [{extension}]:" + "".join(
            told
        )
        self.__cause__ = likely_errors[0]

    def __str__(self) -> str:
        return self._text


class InvalidFrontendLaunchFileError(InvalidLaunchFileError):
    """Raised when an XML or YAML file is not a valid launch file."""
