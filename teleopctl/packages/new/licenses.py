"""Licenses whose text a new package gets, by their SPDX identifiers."""

from __future__ import annotations

from pathlib import Path
from typing import Final

_FOLDER: Final = Path(__file__).parent / "licenses"

# BSD-2.0 is what ament's tools call the license of three clauses, too.
_FILES: Final = {
    "Apache-2.0": "Apache-2.0",
    "BSL-1.0": "BSL-1.0",
    "BSD-2.0": "BSD-3-Clause",
    "BSD-2-Clause": "BSD-2-Clause",
    "BSD-3-Clause": "BSD-3-Clause",
    "GPL-3.0-only": "GPL-3.0-only",
    "LGPL-3.0-only": "LGPL-3.0-only",
    "MIT": "MIT",
    "MIT-0": "MIT-0",
}


def license_names() -> list[str]:
    """Return the identifiers of the licenses with known text."""
    return list(_FILES)


def license_text(name: str, holder: str, year: int) -> str | None:
    """Return the text of a license, or None.

    Args:
        name: Its SPDX identifier.
        holder: Who has the copyright.
        year: Since when.
    """
    if name not in _FILES:
        return None
    text = _FOLDER.joinpath(f"{_FILES[name]}.txt").read_text(encoding="utf-8")
    return text.replace("{year}", str(year)).replace("{holder}", holder)
