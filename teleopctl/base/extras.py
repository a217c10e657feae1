"""Optional libraries: a missing one is reported with the extra that installs it.

This is a separate module, so that verbs that check for an optional library load nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from teleopctl.errors import MissingExtraError


@contextmanager
def extra(name: str, *modules: str) -> Iterator[None]:
    """Turn a failed import of given modules in a ``with`` block into an error that names the extra.

    Args:
        name: Name of the extra in `pyproject.toml`.
        modules: Top-level modules that the extra installs. If another module is missing, which is
            a defect, its ModuleNotFoundError passes through.

    Raises:
        MissingExtraError: One of the modules is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in modules:
            raise
        raise MissingExtraError(
            f"This needs {error.name.partition('.')[0]}, which is not installed",
            hint=f"Install it with: pip install {_requirement(name)}",
        ) from error


def _requirement(name: str) -> str:
    """Requirement for pip that installs the extra from the source of this installation."""
    from importlib.metadata import PackageNotFoundError, distribution

    record = None
    with suppress(PackageNotFoundError):
        record = distribution("teleopctl").read_text("direct_url.json")
    if record is not None:
        source = _source(record)
    else:
        # No record: a checkout on the path that is not installed, or a package of an index.
        checkout = Path(__file__).parents[2]
        source = checkout if (checkout / "pyproject.toml").is_file() else None
    if source is None:
        return f"'teleopctl[{name}]'"
    if isinstance(source, str):
        return f"'teleopctl[{name}] @ {source}'"
    with suppress(OSError):  # The current folder may be gone.
        if source.samefile("."):
            return f"'.[{name}]'"
    return f"'{source}[{name}]'"


def _source(record: str) -> Path | str | None:
    """Folder or URL in a record of PEP 610; None if the folder does not exist."""
    import json
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    origin = json.loads(record)
    url = str(origin["url"])
    if "dir_info" in origin:
        folder = Path(url2pathname(urlsplit(url).path))
        return folder if folder.is_dir() else None
    if "vcs_info" in origin:
        return f"{origin['vcs_info']['vcs']}+{url}@{origin['vcs_info']['commit_id']}"
    return url
