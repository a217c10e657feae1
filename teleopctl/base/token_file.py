"""Access tokens of servers, which clients must send, in files of mode 0600.

A token never appears in arguments, logs, parameters or progress files, which others can read or
which are published. Programs pass on the path of the file. The token itself is shown only to the
user who starts a server, in the URL to open.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
import sys
from pathlib import Path
from urllib.parse import quote, unquote

from teleopctl.base.access import with_token
from teleopctl.base.files import open_private
from teleopctl.base.folders import make_private, state_dir
from teleopctl.base.typed import NamedTuple
from teleopctl.errors import InvalidFileError, SystemFailureError, TeleopctlError

_BYTES = 24
# In bytes. A larger file is not a token file, but was named by mistake.
_LARGEST_FILE = 4096


class Address(NamedTuple):
    """URL of a server, and the file of its access token.

    Attributes:
        url: URL to open, without the token.
        token_file: File of the token that the server requires; None if it requires none.
    """

    url: str
    token_file: Path | None = None

    @property
    def with_token(self) -> str:
        """URL with the token as query; the plain URL if there is none or it cannot be read."""
        if self.token_file is None:
            return self.url
        try:
            return with_token(self.url, read_token(self.token_file))
        except TeleopctlError:
            return self.url

    @property
    def announcement(self) -> str:
        """Line with the URL and its token, for the terminal of the user who started the server."""
        what = "Address for Foxglove" if self.url.startswith("ws") else "The robot in your browser"
        return f"{what}: {self.with_token}"

    @classmethod
    def parse(cls, text: str) -> Address:
        """Return the address in a text of the form ``URL [FILE]``, the file path URL-quoted."""
        url, _, file = text.partition(" ")
        return cls(url, Path(unquote(file)) if file else None)

    def __str__(self) -> str:
        return self.url if self.token_file is None else f"{self.url} {quote(str(self.token_file))}"


def default_token_file() -> Path:
    """Return the path of the user's default token file, which may not exist."""
    return state_dir() / "token"


def read_or_make_token(file: Path) -> str:
    """Return the token in a file; create the file with a new token if it is missing.

    Raises:
        InvalidFileError: Others can read the file, or the file holds no token.
        SystemFailureError: The file cannot be read or created.
    """
    try:
        if not file.exists():
            _make(file)
    except OSError as error:
        raise SystemFailureError(
            f"Cannot make the token file {file}: {error.strerror}",
            hint="Name another one.",
        ) from error
    return read_token(file)


def read_token(file: Path) -> str:
    """Return the token in an existing file.

    Raises:
        InvalidFileError: Others can read the file, or the file holds no token.
        SystemFailureError: The file cannot be read.
    """
    try:
        # Opening a pipe would block until another process opens it for writing.
        descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with open(descriptor, "rb") as stream:  # noqa: PTH123 -- a descriptor
            _check(file, os.fstat(descriptor))
            data = stream.read(_LARGEST_FILE + 1)
    except OSError as error:
        raise SystemFailureError(f"Cannot read the token file {file}: {error.strerror}") from error
    try:
        token = data.decode("utf-8").removesuffix("\n").removesuffix("\r")
    except UnicodeDecodeError as error:
        raise InvalidFileError(f"The token in {file} is not UTF-8 text") from error
    if not token.strip() or len(data) > _LARGEST_FILE or not token.isprintable():
        raise InvalidFileError(
            f"{file} holds no token",
            hint="A token is one line of text. Without the file, one is made.",
        )
    return token


def _check(file: Path, found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise InvalidFileError(f"The token file {file} is not a regular file")
    if sys.platform == "win32":
        return
    if stat.S_IMODE(found.st_mode) & 0o077:
        raise InvalidFileError(
            f"Others can read the token file {file}",
            hint=f"Put a new token into it, or remove it, and give it mode 0600: chmod 600 {file}",
        )
    if found.st_uid not in (os.geteuid(), 0):
        raise InvalidFileError(f"The token file {file} belongs to another user")


def _make(file: Path) -> None:
    if file == default_token_file():
        make_private(file.parent)
    draft = file.with_name(f"{file.name}.{os.getpid()}.new")
    try:
        with open(draft, "w", encoding="utf-8", opener=open_private) as stream:
            stream.write(f"{secrets.token_urlsafe(_BYTES)}\n")
        # A link, unlike a rename, never replaces a token that another process has just made.
        with contextlib.suppress(FileExistsError):
            os.link(draft, file)
    finally:
        draft.unlink(missing_ok=True)
