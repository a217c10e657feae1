"""Memory that large messages have freed is kept for the next ones.

The C library of most Linux systems gives each large block back to the kernel as it is freed, and
the kernel clears the pages of the next one as they are touched: 2,200 of an image of 9 MB each time
that it is copied, which takes 1 to 4 ms in a virtual machine.
"""

from __future__ import annotations

import os
import sys

# Parameters of glibc's mallopt(3), in bytes. It takes no larger blocks than these 32 MiB from what
# is kept.
_M_TRIM_THRESHOLD, _MOST_KEPT = -1, 256 * 2**20
_M_MMAP_THRESHOLD, _LARGEST_KEPT = -3, 32 * 2**20

# Who sets these has decided himself.
_BY_USER = ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_", "GLIBC_TUNABLES")

_is_kept = False


def keep_freed_memory() -> None:
    """Have up to 256 MiB of freed memory kept by this process, from the first call on.

    Without effect on systems that do not have glibc, or where the user's environment says how
    memory is to be kept.
    """
    global _is_kept
    if _is_kept:
        return
    _is_kept = True
    if sys.platform != "linux" or any(name in os.environ for name in _BY_USER):
        return
    import ctypes

    try:
        set_option = ctypes.CDLL(None).mallopt
    except AttributeError:  # another C library
        return
    set_option(_M_TRIM_THRESHOLD, _MOST_KEPT)
    set_option(_M_MMAP_THRESHOLD, _LARGEST_KEPT)
