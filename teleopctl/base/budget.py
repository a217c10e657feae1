"""Limits on the size and work of decompressing and expanding input, shared by all readers.

A few kilobytes can stand for gigabytes: compressed zeros, macros in macros, aliases of aliases, a
variable that doubles itself. Whatever unpacks or expands asks here before it makes something, so
that a file which is over the budget is refused before it has taken memory or time.

Nearly all bounds are on work (bytes, elements, depth) and not on seconds: what a machine reads, it
reads on a busy day too. Seconds are the last resort for expressions, whose operations differ.

The figures leave real files several times of what they take: seven times of elements of xacro,
and more than ten times of other counts. Chunks and pictures, which are memory, have the largest
that are in use. Measured, of what was found in public repositories (PR2, UR10e, Franka FR3 and
FP3, Spot, xArm, Husky, TALOS, TIAGo, MoveIt's resources):

==========================  =======================================================  ==============
what                        the most that a real file takes                          budget
==========================  =======================================================  ==============
xacro: elements made        4,381 (PR2)                                              30,000
xacro: macro calls          136 (PR2)                                                10,000
xacro: files included       51 (PR2)                                                 1,000
xacro: characters made      106,182 (PR2)                                            10 million
xacro: operations           231 (PR2)                                                200,000
xacro: parts made by them   2,299 (Franka's two arms)                                2 million
URDF, characters            210,669 (TIAGo with two arms)                            10 million
launch: steps               some 300 (MoveIt's demos with their includes)            20,000
chunk of a bag, bytes       1 to 4 MB by default, 100 MB by preference               128 MB, or 64
                                                                                     times its size
compression                 2 to 10 times of sensor data; 64 times of rendered       see there
                            depth images
all chunks of a file        the same                                                 1 GiB, or 64
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
"""What anything may be unpacked to in memory: more than the largest chunks that writers make."""
UNPACKED_RATIO: Final = 64
"""How many times its size something larger may be unpacked to."""
LARGEST_UNPACKED_BYTES: Final = 2**30
"""What nothing may exceed in memory."""
UNPACKED_FILE_BYTES: Final = 2**30
"""What a file may be unpacked to in all: on the disk, if it says its size, or part by part."""
MOST_RECORDS: Final = 500_000
"""Records of a chunk: 100 MB of messages with 170 bytes and their heads."""
SMALLEST_RECORD_BYTES: Final = 9
MOST_PIXELS: Final = 8192 * 8192
"""Pixels of a picture that is decoded: a texture of 8k, 268 MB with its opacity."""

# -- texts that make texts -------------------------------------------------------------------------

LONGEST_TEXT: Final = 1_000_000
"""Characters of one text that an expression or an attribute makes, parts of one list."""
LONGEST_DOCUMENT: Final = 10_000_000
"""Characters of all that a file expands to, and of a launch variable, which may be a robot."""
MOST_LAUNCH_TEXT: Final = 200_000_000
"""Characters that the texts of a launch make in all."""
LARGEST_INTEGER_BITS: Final = 10_000
"""Some 3,000 digits: Python itself refuses to write more than 4,300."""
MOST_OPERATIONS: Final = 200_000
"""Operations of the expressions of a xacro file."""
MOST_MADE: Final = 2_000_000
"""Parts that these make in all; lists of that size are 80 MB."""
LONGEST_EXPRESSIONS_S: Final = 5.0
"""Processor time of a file's expressions, so that a busy machine changes nothing."""

# -- elements that make elements -------------------------------------------------------------------

MOST_ELEMENTS: Final = 30_000
"""Elements that the macros, blocks and includes of a xacro file make."""
MOST_MACRO_CALLS: Final = 10_000
MOST_INCLUDED_FILES: Final = 1_000
"""Files that a xacro or launch file includes, each time counted."""
MOST_COPIES: Final = 10_000
"""Elements that MJCF's replicate and attach make: MuJoCo's parser takes 10 s for so many, and four
times as long for twice as many."""
MOST_STEPS: Final = 20_000
"""Steps that a launch takes with its loops and includes."""
DEEPEST_INCLUDES: Final = 30
"""Files that include one another, in launch files."""
DEEPEST_FORESIGHT: Final = 5
"""Timers and events that lead to one another, of which a launch looks ahead."""
DEEPEST_TAGS: Final = 50
"""Tags or entries in one another, in launch files."""
DEEPEST_YAML: Final = 100
"""Lists and mappings in one another; libyaml's own recursion ends at some ten thousand."""
MOST_FROM_ALIASES: Final = 100_000
"""Values that YAML's aliases add."""


def joined(parts: Sequence[str], separator: str = "") -> str:
    """Join texts; raise a BudgetError if the result exceeds the limit of a document.

    Raises:
        BudgetError: It would be.
    """
    if sum(map(len, parts)) + len(separator) * len(parts) > LONGEST_DOCUMENT:
        raise BudgetError(f"a text of more than {LONGEST_DOCUMENT:,} characters")
    return separator.join(parts)


class BudgetError(ValueError):
    """A limit on size or work is exceeded; the message names the limit."""


class Tally:
    """Counter of expanded elements that raises a BudgetError beyond a limit.

    Args:
        what: In the plural, for the refusal: ``elements``.
        most: How many there may be.

    Attributes:
        count: How many there were so far.
    """

    __slots__ = ("_most", "_what", "count")

    def __init__(self, what: str, most: int) -> None:
        self._what = what
        self._most = most
        self.count = 0

    def add(self, count: int = 1) -> None:
        """Add to the count; raise a BudgetError beyond the limit.

        Raises:
            BudgetError: They are too many.
        """
        self.count += count
        if self.count > self._most:
            raise BudgetError(f"more than {self._most:,} {self._what}")


def unpacked_limit(stored: int, least: int = UNPACKED_BYTES) -> int:
    """Return the largest allowed unpacked size, in bytes, of stored data.

    Args:
        stored: How many bytes it has.
        least: What anything may become, however small it is.
    """
    return max(least, UNPACKED_RATIO * stored)


def may_be_unpacked(claimed: int, stored: int) -> bool:
    """Return whether a claimed unpacked size is allowed."""
    return claimed <= min(unpacked_limit(stored), LARGEST_UNPACKED_BYTES)


def tally_of_unpacked(stored: int) -> Tally:
    """Return a counter of unpacked bytes, limited by the stored size of a file.

    Args:
        stored: How many bytes the file has.
    """
    return Tally(
        f"bytes that its {stored:,} are unpacked to", unpacked_limit(stored, UNPACKED_FILE_BYTES)
    )


def check_unpacked(claimed: int, stored: int) -> None:
    """Raise a BudgetError if the claimed unpacked size exceeds the limit of stored data.

    Args:
        claimed: How many bytes it says it becomes.
        stored: How many it has.

    Raises:
        BudgetError: It may not.
    """
    if not may_be_unpacked(claimed, stored):
        most = min(unpacked_limit(stored), LARGEST_UNPACKED_BYTES)
        raise BudgetError(
            f"its {stored:,} bytes would become {claimed:,}; at most {most:,} are unpacked"
        )


def check_pixels(width: int, height: int) -> None:
    """Raise if a picture is too large to decode.

    Raises:
        BudgetError: It is.
    """
    if width * height > MOST_PIXELS:
        raise BudgetError(f"has {width} x {height} pixels: at most {MOST_PIXELS:,} are decoded")
