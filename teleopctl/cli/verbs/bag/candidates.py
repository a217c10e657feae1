"""What Tab offers for bags."""

from __future__ import annotations

from pathlib import Path

_SUFFIXES = (".mcap", ".db3", ".bag", ".zstd")


def bags(incomplete: str) -> list[str]:
    """Return bags and folders that complete a path."""
    typed = Path(incomplete)
    folder = typed if not incomplete or incomplete.endswith("/") else typed.parent
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return []
    found = [str(entry) for entry in entries if entry.is_dir() or entry.suffix in _SUFFIXES]
    return [name for name in found if name.startswith(incomplete)]
