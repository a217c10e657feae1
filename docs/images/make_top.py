"""Makes the picture of ``teleopctl top`` in a graph with something to see (``launch sim.yaml``)."""

from __future__ import annotations

import asyncio
from pathlib import Path

from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.top.app import Top

PICTURE = Path(__file__).with_name("top_topics.svg")
SIZE = (110, 30)
LISTENS_S = 6.0


async def main() -> None:
    """Show the topics for a while, and keep what stands there."""
    with command_node() as node:
        app = Top(node, 1.0)
        async with app.run_test(size=SIZE) as pilot:
            await pilot.press("2")
            await pilot.pause(LISTENS_S)
            PICTURE.write_text(app.export_screenshot(simplify=True), encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(main())
