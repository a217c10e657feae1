"""Runs the fuzzers and the fault campaigns, one after the other.

``python -m tests.nightly`` takes about four hours, without ``tests.faults.stops`` one, with
``--quick`` a few minutes. What each prints is printed here; the exit status is 1 if one of them
found a defect.
"""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
import time
from pathlib import Path

# The cube comes into the bin by handle, keys, gamepad and touch pads, in a real browser.
_CUBE = "tests/system/test_drive.py::test_the_cube_comes_into_the_bin"
# Module, arguments of the full run, and arguments of the quick run.
CAMPAIGNS = (
    ("tests.fuzz.decoders", "--count 1000000", "--count 20000"),
    ("tests.fuzz.graph", "--count 20000", "--count 1000"),
    ("tests.fuzz.bags", "--count 3000", "--count 50"),
    ("tests.faults.interrupts", "--count 100 --busy 2", "--count 3 --busy 0"),
    ("tests.faults.router", "--count 20 --down 8", "--count 2 --down 2"),
    ("tests.faults.soak", "--seconds 600", "--seconds 20"),
    ("tests.faults.page_soak", "--minutes 10", "--minutes 0.5"),
    ("tests.faults.frozen", "", ""),
    ("tests.faults.control", "", "--quick blocks killed reload"),
    ("tests.faults.episodes", "--count 20", "--count 3"),
    ("tests.faults.stops", "--count 100", "--count 2"),
    ("pytest", f"-q {_CUBE}", f"-q {_CUBE}[keys-size1]"),
)
# The same of those that need an environment with lerobot, whose Python is their first argument.
OF_LEROBOT = (
    ("tests.lerobot_programs", "", ""),
    ("tests.lerobot_episodes", "--count 20 --hand 5", "--count 1 --hand 1"),
)


def main() -> None:
    """Run all campaigns; print exit status and duration of each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of names of those to run")
    parser.add_argument("--without", action="append", default=[], metavar="NAME")
    parser.add_argument("--quick", action="store_true", help="a few trials of each")
    parser.add_argument("--lerobot", metavar="PYTHON", help="a Python with lerobot: those, too")
    options = parser.parse_args()
    wanted = [
        campaign
        for campaign in CAMPAIGNS
        if (not options.names or any(part in campaign[0] for part in options.names))
        and not any(part in campaign[0] for part in options.without)
    ]
    if not wanted:
        parser.error(f"there are: {', '.join(module for module, *_ in CAMPAIGNS)}")
    outcomes: list[str] = []
    failed = 0
    for module, whole, quick in wanted:
        words = ["-m", module, *shlex.split(quick if options.quick else whole)]
        print(f"\n$ python {shlex.join(words)}", flush=True)
        start_s = time.monotonic()
        done = subprocess.run([sys.executable, *words], cwd=Path(__file__).parents[1], check=False)
        failed += done.returncode != 0
        seconds = time.monotonic() - start_s
        outcomes.append(f"{module:24} status {done.returncode}, {seconds:.0f} s")
    print("", *outcomes, sep="\n")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
