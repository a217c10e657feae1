"""Tests; a package, so that test files can import helper modules."""

from pathlib import Path

ROOT = Path(__file__).parents[1]

# Arguments for a pytest process that a test starts: without the plug-ins that only its parent
# needs, whose import takes half of the process's time.
LEAN_PYTEST = tuple(
    word
    for name in ("anyio", "benchmark", "hypothesispytest", "xdist", "xdist.looponfail")
    for word in ("-p", f"no:{name}")
)
