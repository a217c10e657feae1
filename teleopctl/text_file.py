"""Reading a text file that a person named."""

from pathlib import Path

from teleopctl.errors import InvalidFileError


def read_text(path: Path) -> str:
    """Read a whole file.

    Raises:
        InvalidFileError: It cannot be read, or is not UTF-8.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidFileError(f"Cannot read {path}: it is not UTF-8 text") from error
