"""Type hashes as values, under the name of ``rclpy.type_hash``."""

from __future__ import annotations

_SIZE = 32


class TypeHash:
    """Hash of a type's definition.

    Args:
        version: Of the way in which it is computed; 1 for RIHS01.
        value: The 32 bytes.
    """

    __slots__ = ("value", "version")

    def __init__(self, version: int = -1, value: bytes = bytes(_SIZE)) -> None:
        self.version = version
        self.value = value

    @classmethod
    def from_text(cls, text: str) -> TypeHash:
        """Parse a type hash such as ``RIHS01_…``; other texts give an invalid hash."""
        version, _, digits = text.removeprefix("RIHS").partition("_")
        try:
            return cls(int(version), bytes.fromhex(digits))
        except ValueError:
            return cls()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return NotImplemented
        return (self.version, self.value) == (other.version, other.value)

    def __hash__(self) -> int:
        return hash((self.version, self.value))

    def __str__(self) -> str:
        if self.version <= 0 or len(self.value) != _SIZE:
            return "INVALID"
        return f"RIHS{self.version:02}_{self.value.hex()}"

    def __repr__(self) -> str:
        return f"TypeHash({self})"
