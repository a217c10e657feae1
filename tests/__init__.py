"""Tests; a package so that they share helpers by name."""

from pathlib import Path

ROOT = Path(__file__).parents[1]

# For a pytest that a test starts: without the plug-ins that only its parent needs, whose import is
# half of its time.
LEAN_PYTEST = tuple(
    word
    for name in ("anyio", "benchmark", "hypothesispytest", "xdist", "xdist.looponfail")
    for word in ("-p", f"no:{name}")
)
