"""Limits on the size and work of decompressing and expanding input, shared by all readers.

A few kilobytes can expand to gigabytes: compressed zeros, macros in macros, aliases of aliases, a
variable that doubles itself. Every decompressor and expander checks these limits before it
allocates, so that a file over a limit is refused before it takes memory or time.

Nearly all limits are on work (bytes, elements, depth) and not on seconds, so that a file is
accepted or refused independent of the load of the machine. Seconds are the last resort for
expressions, whose operations differ in cost.

The limits are several times what real files need: seven times for elements of xacro, and more than
ten times for other counts. Limits on memory, of chunks and pictures, are the largest sizes in use.
Measured on files in public repositories (PR2, UR10e, Franka FR3 and FP3, Spot, xArm, Husky, TALOS,
TIAGo, MoveIt's resources):

==========================  =======================================================  ==============
quantity                    largest value in a real file                             limit
==========================  =======================================================  ==============
xacro: elements made        4,381 (PR2)                                              30,000
xacro: macro calls          136 (PR2)                                                10,000
xacro: files included       51 (PR2)                                                 1,000
xacro: characters made      106,182 (PR2)                                            10 million
xacro: operations           231 (PR2)                                                200,000
xacro: size of all results  2,299 (Franka's two arms)                                2 million
URDF, characters            210,669 (TIAGo with two arms)                            10 million
launch: steps               some 300 (MoveIt's demos with their includes)            20,000
chunk of a bag, bytes       1 to 4 MB by default, 100 MB by preference               128 MB, or 64
                                                                                     times its size
compression ratio           2 to 10 for sensor data; 64 for rendered depth images    see chunks
all chunks of a file        as for one chunk                                         1 GiB, or 64
                                                                                     times its size
texture, pixels             8192 x 8192                                              8192 x 8192
==========================  =======================================================  ==============
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Final

# -- decompression ---------------------------------------------------------------------------------

UNPACKED_BYTES: Final = 128 * 2**20
"""Unpacked size in memory that is always allowed: more than the largest chunks of writers."""
UNPACKED_RATIO: Final = 64
"""Largest ratio of unpacked to stored size above the sizes that are always allowed."""
LARGEST_UNPACKED_BYTES: Final = 2**30
"""Upper limit of any unpacked size in memory."""
UNPACKED_FILE_BYTES: Final = 2**30
"""Unpacked size of a whole file that is always allowed: on disk, if the file states its size, or
chunk by chunk."""
MOST_RECORDS: Final = 500_000
"""Largest number of records of a chunk: 100 MB of messages with 170 bytes and their headers."""
SMALLEST_RECORD_BYTES: Final = 9
MOST_PIXELS: Final = 8192 * 8192
"""Largest number of pixels of a decoded picture: an 8k texture, 268 MB with alpha channel."""

# -- expanded texts --------------------------------------------------------------------------------

LONGEST_TEXT: Final = 1_000_000
"""Largest number of characters of a text, or of items of a list, from one expression or
attribute."""
LONGEST_DOCUMENT: Final = 10_000_000
"""Largest number of characters of an expanded file, or of a launch variable, which may hold a
robot description."""
MOST_LAUNCH_TEXT: Final = 200_000_000
"""Largest number of characters of all texts in a launch."""
LARGEST_INTEGER_BITS: Final = 10_000
"""About 3,000 digits; Python itself refuses to print more than 4,300."""
MOST_OPERATIONS: Final = 200_000
"""Largest number of operations in the expressions of a xacro file."""
MOST_MADE: Final = 2_000_000
"""Largest number of characters and items that these operations make in all; lists of that size
take 80 MB."""
LONGEST_EXPRESSIONS_S: Final = 5.0
"""Longest processor time of a file's expressions; processor time is independent of the load."""

# -- expanded elements -----------------------------------------------------------------------------

MOST_ELEMENTS: Final = 30_000
"""Largest number of elements made by the macros, blocks and includes of a xacro file."""
MOST_MACRO_CALLS: Final = 10_000
MOST_INCLUDED_FILES: Final = 1_000
"""Largest number of includes of a xacro or launch file, repeated ones counted each time."""
MOST_COPIES: Final = 10_000
"""Largest number of elements made by MJCF's replicate and attach: MuJoCo's parser takes 10 s for
this number, and four times as long for twice as many."""
MOST_STEPS: Final = 20_000
"""Largest number of steps of a launch, including those in loops and included files."""
DEEPEST_INCLUDES: Final = 30
"""Largest depth of nested includes in launch files."""
DEEPEST_FORESIGHT: Final = 5
"""Largest depth of timers and events that trigger one another in a dry run of a launch."""
DEEPEST_TAGS: Final = 50
"""Largest depth of nested tags or entries in launch files."""
DEEPEST_YAML: Final = 100
"""Largest depth of nested lists and mappings; libyaml's own recursion ends at about 10,000."""
MOST_FROM_ALIASES: Final = 100_000
"""Largest number of values added by YAML aliases."""


def joined(parts: Sequence[str], separator: str = "") -> str:
    """Join texts; raise a BudgetError for more than `LONGEST_DOCUMENT` characters.

    Raises:
        BudgetError: The result would have more than `LONGEST_DOCUMENT` characters.
    """
    if sum(map(len, parts)) + len(separator) * len(parts) > LONGEST_DOCUMENT:
        raise BudgetError(f"a text of more than {LONGEST_DOCUMENT:,} characters")
    return separator.join(parts)


class BudgetError(ValueError):
    """A limit on size or work is exceeded; the message names the limit."""


class Tally:
    """Counter that raises a BudgetError when its count exceeds a limit.

    Args:
        what: Name of the counted things in the error message, in the plural: ``elements``.
        most: Largest allowed count.

    Attributes:
        count: Number counted so far.
    """

    __slots__ = ("_most", "_what", "count")

    def __init__(self, what: str, most: int) -> None:
        self._what = what
        self._most = most
        self.count = 0

    def add(self, count: int = 1) -> None:
        """Increase the count; raise a BudgetError if it then exceeds the tally's limit.

        Raises:
            BudgetError: The count exceeds the limit.
        """
        self.count += count
        if self.count > self._most:
            raise BudgetError(f"more than {self._most:,} {self._what}")


def unpacked_limit(stored_bytes: int, minimum_bytes: int = UNPACKED_BYTES) -> int:
    """Return the allowed unpacked size: 64 times the stored size, at least `minimum_bytes`.

    Args:
        stored_bytes: Size of the stored data, in bytes.
        minimum_bytes: Unpacked size that is always allowed, in bytes.
    """
    return max(minimum_bytes, UNPACKED_RATIO * stored_bytes)


def may_be_unpacked(claimed_bytes: int, stored_bytes: int) -> bool:
    """Return whether the claimed unpacked size of data is within the limit for its stored size."""
    return claimed_bytes <= min(unpacked_limit(stored_bytes), LARGEST_UNPACKED_BYTES)


def tally_of_unpacked(stored_bytes: int) -> Tally:
    """Return a `Tally` of a file's unpacked bytes: limit 1 GiB or, if larger, 64 times its size.

    Args:
        stored_bytes: Size of the file, in bytes.
    """
    return Tally(
        f"bytes that its {stored_bytes:,} are unpacked to",
        unpacked_limit(stored_bytes, UNPACKED_FILE_BYTES),
    )


def check_unpacked(claimed_bytes: int, stored_bytes: int) -> None:
    """Raise a BudgetError if data's claimed unpacked size exceeds the limit for its stored size.

    Args:
        claimed_bytes: Unpacked size that the data states, in bytes.
        stored_bytes: Size of the stored data, in bytes.

    Raises:
        BudgetError: The limit is exceeded.
    """
    if not may_be_unpacked(claimed_bytes, stored_bytes):
        most = min(unpacked_limit(stored_bytes), LARGEST_UNPACKED_BYTES)
        raise BudgetError(
            f"its {stored_bytes:,} bytes would become {claimed_bytes:,}; "
            f"at most {most:,} are unpacked"
        )


def check_pixels(width: int, height: int) -> None:
    """Raise a BudgetError if a picture has too many pixels to decode.

    Raises:
        BudgetError: The picture has more than `MOST_PIXELS` pixels.
    """
    if width * height > MOST_PIXELS:
        raise BudgetError(f"has {width} x {height} pixels: at most {MOST_PIXELS:,} are decoded")
