"""Panel with the graph of nodes and topics, as rqt_graph draws it."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.diagram import ros_graph, to_svg
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.base import Page, Panel

_SHOWN = {"Nodes and topics": "active", "Nodes only": "nodes", "All topics": "all"}
# The layout takes about a second; larger graphs are not readable.
_MOST_BOXES = 400
_TICKS_BETWEEN_PICTURES = 10

# The picture is the label of the hidden checkbox before it, which works without a script.
_PICTURE = """<style>
.graph-large {{ display: none }}
.graph-picture {{ display: block; overflow: auto; max-height: 60vh; padding: 0 12px;
  cursor: zoom-in }}
.graph-large:checked ~ .graph-picture {{ position: fixed; inset: 12px; max-height: none;
  z-index: 1000; cursor: zoom-out; padding: 12px; border-radius: 6px;
  background: var(--mantine-color-body); border: 1px solid #8a94a0 }}
.graph-large:checked ~ .graph-picture svg {{ min-width: 100%; height: auto }}
</style>
<input type="checkbox" class="graph-large" id="graph-large">
<label class="graph-picture" for="graph-large">{svg}</label>
<div style="padding: 4px 12px; font-size: 12px; opacity: .6">Click to enlarge.</div>"""


class GraphPanel(Panel):
    """Panel with the graph of nodes and topics, redrawn after each change of the graph."""

    title: ClassVar[str] = "Graph"
    icon = "topology-star-3"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._svg = ""
        self._is_old = True
        self._is_being_drawn = False
        self._ticks = _TICKS_BETWEEN_PICTURES

    def build(self) -> None:
        """Add the choice of what to draw, the drawing and a button to save it."""
        self._shown: Any = self.gui.add_dropdown("Show", tuple(_SHOWN))
        self._hidden: Any = self.gui.add_checkbox(
            "Show hidden", False, hint="/rosout, /clock, this page, names with _ and the like"
        )
        for choice in (self._shown, self._hidden):
            choice.on_update(self.page.on_node_thread(lambda _event: self._choose()))
        self._picture = self.gui.add_html("")
        self._save = self.gui.add_button("Save as SVG")
        self._save.on_click(self.page.on_node_thread(self._send))

    def graph_changed(self) -> None:
        """Mark the drawing as outdated; called when the ROS graph has changed."""
        self._is_old = True

    def _choose(self) -> None:
        self._is_old = True
        self._ticks = _TICKS_BETWEEN_PICTURES

    def tick(self) -> None:
        """Redraw an outdated graph in another thread, at most once a second."""
        self._ticks += 1
        if not self._is_old or self._is_being_drawn or self._ticks < _TICKS_BETWEEN_PICTURES:
            return
        self._is_old, self._is_being_drawn, self._ticks = False, True, 0
        graph = self.page.node.graph()
        shown, include_hidden = _SHOWN[self._shown.value], bool(self._hidden.value)

        def draw() -> str:
            diagram = ros_graph(graph, shown, include_hidden=include_hidden)
            if len(diagram.boxes) > _MOST_BOXES:
                raise ValueError(
                    f"{len(diagram.boxes)} nodes and topics are too many for a picture; "
                    "'teleopctl graph' writes them for Graphviz."
                )
            return to_svg(diagram)

        self.page.stage.run_in_background(draw, self._take)

    def _take(self, drawn: Any) -> None:
        self._is_being_drawn = False
        if isinstance(drawn, Exception):
            self._svg = ""
            content = f'<div style="padding:0 12px">{escaped_html(str(drawn))}</div>'
        elif drawn == self._svg:
            return
        else:
            self._svg = drawn
            content = _PICTURE.format(svg=drawn)
        self._picture.content = content
        self._save.visible = bool(self._svg)

    def _send(self, event: Any) -> None:
        event.client.send_file_download("graph.svg", self._svg.encode(), save_immediately=True)
