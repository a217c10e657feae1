"""Freed memory serves the next large blocks."""

import os
import platform
import subprocess
import sys

import pytest

PROGRAM = """
import resource
from teleopctl.base.kept_memory import keep_freed_memory

print(keep_freed_memory(), keep_freed_memory())
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(20):
    bytearray(9_000_000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
PAGES = 9_000_000 // 4096


def run(**env: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc has the setting")
def test_blocks_that_were_freed_are_used_again_without_new_pages():
    first, again, faults = run()
    assert (first, again) == ("True", "True")
    assert int(faults) < 3 * PAGES


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc has the setting")
def test_the_users_setting_of_the_allocator_holds():
    first, again, faults = run(MALLOC_MMAP_THRESHOLD_="1000000")
    assert (first, again) == ("False", "False")
    assert int(faults) > 15 * PAGES


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc returns it")
def test_freed_memory_is_returned_to_the_kernel():
    code = (
        "import os\n"
        "from teleopctl.base.kept_memory import keep_freed_memory, return_freed_memory\n"
        "pages = lambda: int(open('/proc/self/statm').read().split()[1])\n"
        "keep_freed_memory()\n"
        "blocks = [bytearray(2**20) for _ in range(50)]\n"
        "del blocks\n"
        "before = pages()\n"
        "return_freed_memory()\n"
        "print((before - pages()) * os.sysconf('SC_PAGESIZE') > 40e6)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
