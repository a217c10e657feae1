"""Findings of ``doctor`` and ``control doctor``, and how they are printed."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.base.typed import NamedTuple
from teleopctl.cli import console
from teleopctl.errors import TeleopctlError


class Finding(NamedTuple):
    """Error or warning of a check of ``doctor``, with a hint for the remedy.

    Attributes:
        text: Description of the fault and its place.
        hint: Remedy for the fault; may be empty.
        is_error: Whether the finding is an error, which fails the check, or a warning.
    """

    text: str
    hint: str = ""
    is_error: bool = True


def warning(text: str, hint: str = "") -> Finding:
    """Return a finding of a possible fault, which is printed as a warning."""
    return Finding(text, hint, is_error=False)


class Found(NamedTuple):
    """Finding with the category and the subject of its check."""

    category: str
    check: str
    finding: Finding


def print_findings(found: Sequence[Found], failed: Sequence[str], total: int) -> None:
    """Print findings to stderr, and how many checks failed to stdout.

    Args:
        found: Findings of all checks.
        failed: Category of each failed check.
        total: Number of checks.
    """
    for _, _, finding in found:
        hint = f"\n  {finding.hint}" if finding.hint else ""
        if finding.is_error:
            console.error(TeleopctlError(finding.text, hint=finding.hint or None))
        else:
            console.warn(finding.text + hint)
    if failed:
        modules = " ".join(dict.fromkeys(failed))
        lines = [f"{len(failed)}/{total} check(s) failed", "", f"Failed modules: {modules}"]
    else:
        lines = [f"All {total} checks passed", ""]
    console.out_lines(["", *lines])


def print_findings_as_json(found: Sequence[Found], checks: Sequence[str]) -> None:
    """Print findings as a JSON document.

    Args:
        found: Findings of all checks.
        checks: Subjects of all checks.
    """
    console.out_json(
        {
            "checks": list(checks),
            "findings": [
                {
                    "category": category,
                    "check": subject,
                    "severity": "error" if finding.is_error else "warning",
                    "text": finding.text,
                    "hint": finding.hint,
                }
                for category, subject, finding in found
            ],
        }
    )
