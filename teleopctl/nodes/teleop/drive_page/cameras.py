"""Pictures of the robot's cameras on the drive page: a websocket for each browser that looks."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING
from urllib.parse import parse_qs

from teleopctl.viewer import CameraPictures

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from teleopctl.pictures import Picture
    from teleopctl.viewer import Viewer

# Bytes that wait for a browser which reads slowly: a newer picture is better.
_MOST_WAITING = 65_536


class DriveCameras:
    """Cameras of the robot, whose pictures are sent to the browsers that show them.

    Args:
        viewer: Viewer whose process subscribes to the images.
    """

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._pictures = CameraPictures(viewer)
        self._topics: list[str] = []
        self._is_outdated = True
        viewer.add_graph_callback(self._note_change)

    def _note_change(self) -> None:
        self._is_outdated = True

    def topics(self) -> list[str]:
        """Return the image topics of the cameras, which are looked up after a change of the graph.

        They may be those of the call before.
        """
        if self._is_outdated:
            self._is_outdated = False
            self._viewer.call_on_node_thread(self._look)
        return self._topics

    def _look(self) -> None:
        self._topics = self._pictures.topics()

    async def serve(self, connection: ServerConnection) -> None:
        """Send the pictures of the topic that a websocket's address names until it closes."""
        request = connection.request
        query = "" if request is None else request.path.partition("?")[2]
        topic = parse_qs(query).get("topic", [""])[0]
        loop = asyncio.get_running_loop()
        newest: asyncio.Queue[Picture] = asyncio.Queue(1)

        def put(picture: Picture) -> None:
            if newest.full():
                newest.get_nowait()
            newest.put_nowait(picture)

        ends: list[Callable[[], None]] = []
        self._viewer.call_on_node_thread(
            lambda: ends.append(
                self._pictures.watch(topic, lambda picture: loop.call_soon_threadsafe(put, picture))
            )
        )
        sender = loop.create_task(self._send(connection, newest))
        try:
            await connection.wait_closed()
        finally:
            sender.cancel()
            # In turn, after the call above.
            self._viewer.call_on_node_thread(lambda: [end() for end in ends])

    @staticmethod
    async def _send(connection: ServerConnection, newest: asyncio.Queue[Picture]) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            while True:
                picture = await newest.get()
                if connection.transport.get_write_buffer_size() < _MOST_WAITING:
                    await connection.send(picture.data)
        except ConnectionClosed:
            pass
