"""Client of the page in place of a browser: reads all messages, and sends user input.

The page sends fewer messages to a browser that draws slowly, such as one without a graphics card.
This client reads all messages at once, so that the page does its maximum of work.
"""

from __future__ import annotations

import http.client
import re
import struct
import threading
from collections import Counter
from collections.abc import Callable
from typing import Any
from urllib.parse import quote

import msgspec
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from teleopctl.testing import LONGEST_WAIT_S

# Header of the messages: their unpacked and packed size in bytes.
_LENGTHS = struct.Struct("<QQ")

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (2.0, -2.0, 1.5),
    "look_at": (0.0, 0.0, 0.5),
    "up_direction": (0.0, 0.0, 1.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 640,
    "image_width": 900,
}
"""Camera pose; viser regards a client as connected when it has sent one."""

PLOTS = 10


class PageClient:
    """Connection to a page of viser.

    Args:
        port: TCP port of the page on this machine.
        storage: The browser's local storage, with what the page has kept in it.

    Attributes:
        storage: See the argument.
        messages: Messages about viser panels, in their order.
        parts: Properties of the GUI elements, such as buttons, by UUID.
        counts: Numbers of received messages by type; ``data`` counts updates of images and plots.
    """

    def __init__(self, port: int, storage: dict[str, str] | None = None) -> None:
        self.storage = {} if storage is None else storage
        self.messages: list[dict[str, Any]] = []
        self._port, self._browser = port, ""
        self.parts: dict[str, dict[str, Any]] = {}
        self.counts: Counter[str] = Counter()
        self._changed = threading.Condition()
        self._socket = connect(
            f"ws://127.0.0.1:{port}/",
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            compression=None,
            max_size=None,
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        self._send(CAMERA)

    def close(self) -> None:
        """Close the connection, and wait for the end of the reading thread."""
        self._socket.close()
        self._reader.join()

    def find(self, label: str, kind: str, *, option: str = "") -> dict[str, Any]:
        """Wait for a GUI element, such as a ``Dropdown`` with a label; return its properties."""

        def found() -> dict[str, Any] | None:
            for part in self.parts.values():
                if (part["label"], part["type"]) == (label, f"Gui{kind}Message") and (
                    not option or option in part["options"]
                ):
                    return part
            return None

        self.wait_for(found)
        part = found()
        assert part is not None
        return part

    def put(self, part: dict[str, Any], value: object) -> None:
        """Set the value of a GUI element, as a user does; True presses a button."""
        part["value"] = value
        self._send({"type": "GuiUpdateMessage", "uuid": part["uuid"], "updates": {"value": value}})

    def show(self, *panels: str, visibility: str = "visible", embedded: bool = False) -> None:
        """Report which panels are visible, as the page's script does in a browser.

        Args:
            panels: Names of the panels.
            visibility: ``visible`` or ``hidden``, for the whole page.
            embedded: Whether the page shows the 3D view alone.
        """
        self._report(
            "/visibility",
            {
                "Teleopctl-Visibility": visibility,
                "Teleopctl-Panels": " ".join(panels),
                "Teleopctl-Embedded": str(embedded).lower(),
            },
        )

    def click(self, panel: str, what: str) -> None:
        """Report a click on an element of a panel's HTML; see `click_mark`."""
        self._report("/click", {"Teleopctl-Click": quote(f"{panel} {what}")})

    def _report(self, path: str, headers: dict[str, str]) -> None:
        self.wait_for(lambda: self._browser)
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=LONGEST_WAIT_S)
        connection.request("GET", path, headers={"Teleopctl-Browser": self._browser, **headers})
        assert connection.getresponse().status == 200
        connection.close()

    @property
    def number(self) -> int:
        """The browser's ID in viser."""
        self.wait_for(lambda: self._browser)
        return int(self._browser)

    def tabs(self) -> list[tuple[str, ...]]:
        """Return the titles of the tabs of each viser panel that the client has now."""
        return [
            tuple(part["_tab_labels"])
            for part in self.parts.values()
            if part["type"] == "GuiPanelMessage" and "".join(part["_tab_labels"]).strip()
        ]

    def wait_for(self, check: Callable[[], object]) -> None:
        """Wait until a condition on the received messages is true; fail after a timeout."""
        with self._changed:
            assert self._changed.wait_for(check, LONGEST_WAIT_S)

    def wait_for_parts(self, kind: str, count: int) -> None:
        """Wait until there are ``count`` GUI elements of a kind; fail after a timeout."""
        name = f"Gui{kind}Message"
        self.wait_for(lambda: sum(part["type"] == name for part in self.parts.values()) == count)

    def _send(self, message: dict[str, Any]) -> None:
        self._socket.send(msgspec.msgpack.encode(message))

    def _read(self) -> None:
        unpack = zstandard.ZstdDecompressor().decompress
        try:
            for data in self._socket:
                assert isinstance(data, bytes)
                size, packed = _LENGTHS.unpack_from(data)
                start = _LENGTHS.size
                content = unpack(data[start : start + packed], max_output_size=size)
                with self._changed:
                    for message in msgspec.msgpack.decode(content)["messages"]:
                        self._take(message)
                    self._changed.notify_all()
        except ConnectionClosed:
            pass

    def _take(self, message: dict[str, Any]) -> None:
        kind, name = message["type"], message.get("uuid", "")
        self.counts[kind] += 1
        if "Panel" in kind:
            self.messages.append(message)
        if kind == "RunJavascriptMessage":
            found = re.search(r'const browser = "(\d+)"', message["source"])
            self._browser = found[1] if found else self._browser
        elif kind == "LocalStorageSetItemMessage":
            self.storage[message["key"]] = message["value"]
        elif kind == "LocalStorageGetItemRequestMessage":
            self._send(
                {
                    "type": "LocalStorageGetItemResponseMessage",
                    "request_uuid": message["request_uuid"],
                    "value": self.storage.get(message["key"]),
                    "error": None,
                }
            )
        elif kind == "GuiPanelRemoveMessage":
            self.parts.pop(name, None)
        if kind == "GuiUpdateMessage":
            self.counts["data"] += not {"data", "_data"}.isdisjoint(message["updates"])
            self.parts.get(name, {}).update(message["updates"])
        elif "props" in message and kind.startswith("Gui"):
            self.parts[name] = {
                "label": "",
                "options": (),
                **message["props"],
                "value": message.get("value"),
                "type": kind,
                "uuid": name,
            }


def show_everything(client: PageClient) -> None:
    """Show the camera, and plot ten numbers of ``/joint_states``, by the page's controls."""
    client.show("camera", "plot", "joints", "scene")
    client.put(client.find("Add", "Text"), "joint_states")

    def numbers() -> list[str]:
        texts = [part.get("content") or "" for part in client.parts.values()]
        return re.findall(
            r'"plot choose ((?:position|velocity)\[[^"]*  /joint_states)"', "".join(texts)
        )

    client.wait_for(lambda: len(numbers()) >= PLOTS)
    for number, name in enumerate(numbers()[:PLOTS], 1):
        client.put(client.find("Where", "Dropdown"), "New plot")
        client.click("plot", f"choose {name}")
        client.wait_for_parts("Uplot", number)
