"""Small installed distributions for tests, made of a folder on the path with metadata."""

from collections.abc import Mapping
from pathlib import Path
from textwrap import dedent


def install(
    site: Path,
    name: str,
    entry_points: Mapping[str, Mapping[str, str]] | str,
    files: Mapping[str, str] | None = None,
) -> Path:
    """Write the files of an installed distribution into a folder.

    Args:
        site: Folder that the test puts on ``PYTHONPATH``.
        name: Name of the distribution.
        entry_points: Value of each entry point by name, by group; or the text of the file.
        files: Text of further files, by path relative to ``site``.

    Returns:
        The folder ``site``.
    """
    metadata = site / f"{name.replace('-', '_')}-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    if not isinstance(entry_points, str):
        entry_points = "\n".join(
            line
            for group, entries in entry_points.items()
            for line in (f"[{group}]", *(f"{key} = {value}" for key, value in entries.items()))
        )
    (metadata / "entry_points.txt").write_text(entry_points)
    for path, text in (files or {}).items():
        file = site / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(dedent(text))
    return site
