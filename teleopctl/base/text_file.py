"""Reading a text file that a person named, or one that stands for a file that is not there yet."""

from pathlib import Path

from teleopctl.errors import InvalidFileError

_POINTER = b"version https://git-lfs.github.com/"


def absence(path: Path) -> str:
    """Return why a file has no real content (a Git LFS pointer), or an empty text.

    In a clone without Git LFS, large files are pointers to what they are.

    Raises:
        OSError: It cannot be read.
    """
    if not path.is_file():
        return ""  # a pipe has no end to be read from before somebody writes
    with path.open("rb") as stream:
        is_pointer = stream.read(len(_POINTER)) == _POINTER
    return "is only a pointer of Git LFS: `git lfs pull` fetches it" if is_pointer else ""


def read_text(path: Path) -> str:
    """Read a text file, or raise an error that names it.

    Raises:
        InvalidFileError: It cannot be read, or is not UTF-8.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidFileError(f"Cannot read {path}: it is not UTF-8 text") from error
