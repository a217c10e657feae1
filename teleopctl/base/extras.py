"""Optional libraries: a missing one is reported with the extra that installs it.

In a module of its own, so that nothing else is loaded by the verbs that look for one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from teleopctl.errors import MissingExtraError


@contextmanager
def extra(name: str, *modules: str) -> Iterator[None]:
    """Raise an error that names the extra to install, if an import in the block fails.

    Args:
        name: The extra, as `pyproject.toml` has it.
        modules: The modules that it brings; any other one that is missing is a defect.

    Raises:
        MissingExtraError: One of them is not installed.
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
    """What pip is to be told, so that it takes the extra from where teleopctl came from."""
    from importlib.metadata import PackageNotFoundError, distribution

    record = None
    with suppress(PackageNotFoundError):
        record = distribution("teleopctl").read_text("direct_url.json")
    if record is not None:
        source = _source(record)
    else:
        # A checkout that is only on the path is not installed; a package index leaves no record.
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
    """The folder or the address in a record of PEP 610; None where there is none."""
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
