"""How the C library keeps memory for pictures, in a process that does nothing but record."""

from __future__ import annotations

import ctypes

# Parameters of glibc's mallopt(3), from malloc.h.
_TRIM_THRESHOLD = -1
_MMAP_THRESHOLD = -3

_LARGEST_KEPT_BYTES = 32 * 2**20  # the most that glibc allows
_KEPT_BYTES = 128 * 2**20


def keep_large_blocks() -> bool:
    """Have blocks of up to 32 MiB used again, in place of new pages for each.

    Each message of a camera passes through several such blocks, and more than half of the
    processor time of writing it went into the system's clearing of fresh pages: frames of 9 MB,
    zstd, 0.68 s of processor time for 40 of them before and 0.36 s after.

    Returns:
        Whether the C library can be told; it is glibc then.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    told = [
        mallopt(_MMAP_THRESHOLD, _LARGEST_KEPT_BYTES),
        mallopt(_TRIM_THRESHOLD, _KEPT_BYTES),
    ]
    return all(told)
