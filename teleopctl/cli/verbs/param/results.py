"""What became of parameters that were set: said to a person at once, to a program in the end."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.cli import console


class Results:
    """Results of setting parameters, printed as text or JSON.

    Args:
        as_json: For a program.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._records: list[console.Json] = []

    def tell(
        self, line: str, node: str, names: Sequence[str], reason: str, *, successful: bool = True
    ) -> None:
        """Add a result; rejections are printed to stderr in any case.

        Args:
            line: What a person reads.
            node: Full name of the node.
            names: The parameters that were set together.
            reason: What the node says of it, or "".
            successful: Whether they have been set.
        """
        self._records.append(
            {"node": node, "parameters": list(names), "successful": successful, "reason": reason}
        )
        if not successful:
            console.flush()
            console.note(line)
        elif not self._as_json:
            console.out(line)

    def say(self, line: str) -> None:
        """Print a line, unless the output is JSON."""
        if not self._as_json:
            console.out(line)

    def finish(self) -> None:
        """Print the JSON document."""
        if self._as_json:
            console.out_json(self._records)
