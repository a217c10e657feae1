"""``rclpy.destroyable``. Interface of handles."""

from types import TracebackType
from typing import Protocol

__all__ = ["DestroyableType"]


class DestroyableType(Protocol):
    """Interface of handles, which are destroyed when their last ``with`` block ends."""

    def __enter__(self) -> None:
        """Use the handle."""

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exctb: TracebackType | None,
    ) -> None:
        """Stop using the handle."""

    def destroy_when_not_in_use(self) -> None:
        """Destroy the handle, at the end of its last ``with`` block."""
