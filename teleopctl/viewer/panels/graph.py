"""Panel with the graph of nodes and topics, as rqt_graph draws it."""

from __future__ import annotations

import re
from functools import partial
from typing import Any, ClassVar

from teleopctl.diagram import Diagram, DiagramBox, ros_graph, to_svg, with_neighbours
from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import Page, Panel, dialog
from teleopctl.viewer.service_calls import is_of_every_node
from teleopctl.viewer.topic_rates import TopicRates

_SHOWN = {"Nodes and topics": "active", "Nodes only": "nodes", "All topics": "all"}
_NAMES, _TYPES, _RATES, _BOTH = "Names", "Types", "Rates", "Types and rates"
# The layout takes about a second; larger graphs are not readable.
_MOST_BOXES = 400
_TICKS_BETWEEN_PICTURES = 10
_MOST_MEASURED = 200
_MOST_LISTED = 12
_ALL = "(all)"
# Stands for a rate while the boxes are laid out, so that the picture keeps its shape when rates
# change: a sign that no name has, with the width of a rate.
_RATE = "\u27e8{:05d}\u27e9"
_RATE_FOUND = re.compile("\u27e8(\\d{5})\u27e9")

# The picture is the label of a hidden checkbox, which works without a script. The checkbox is an
# element of its own, so that a new picture leaves it as it is. The bar stays in view below the
# large picture.
_ENLARGER = """<style>
.graph-large { display: none }
.graph-picture { display: block; overflow: auto; max-height: 60vh; padding: 0 12px;
  cursor: zoom-in }
.graph-picture svg { max-width: 100%; height: auto; max-height: 58vh }
body:has(.graph-large:checked) .graph-picture { position: fixed; inset: 12px 12px 190px;
  max-height: none; z-index: 1000; cursor: zoom-out; padding: 12px; border-radius: 6px;
  background: var(--mantine-color-body); border: 1px solid #8a94a0 }
body:has(.graph-large:checked) .graph-picture svg { width: 100%; height: 100%; max-height: none }
body:has(.graph-large:checked) .graph-picture::after { content: "\\00d7"; position: absolute;
  right: 16px; top: 8px; font-size: 24px; line-height: 1 }
</style>
<input type="checkbox" class="graph-large" id="graph-large">"""
_PICTURE = """<label class="graph-picture" for="graph-large">{svg}</label>
<div style="padding: 4px 12px; font-size: 12px; opacity: .6">
Click to enlarge; click a name for more. {count}</div>"""


class GraphPanel(Panel):
    """Panel with the graph of nodes and topics, redrawn after each change of the graph."""

    title: ClassVar[str] = "Graph"
    icon = "topology-star-3"
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._diagram: Diagram | None = None
        self._svg = ""
        self._is_old = True
        self._is_being_drawn = False
        self._is_watched = False
        self._ticks = _TICKS_BETWEEN_PICTURES
        self._meter = page.shared(TopicRates)
        # Measured topics; the place of a topic is the number of its rate in the picture.
        self._measured: list[str] = []

    def build(self) -> None:
        """Add the choice of what to draw, the drawing and a button to save it."""
        self._search: Any = self.gui.add_text(
            "Search",
            "",
            hint="Part of the name of a node or topic; what it is connected with stays",
        )
        self.gui.add_html(_ENLARGER)
        self._picture = self.gui.add_html("")
        self._shown: Any = self.gui.add_dropdown("Show", tuple(_SHOWN))
        self._arrows: Any = self.gui.add_dropdown(
            "Topics with",
            (_NAMES, _TYPES, _RATES, _BOTH),
            hint="Rates subscribe to the topics while this panel is visible",
        )
        self._space: Any = self.gui.add_dropdown("Namespace", (_ALL,))
        self._hidden: Any = self.gui.add_checkbox(
            "Show hidden", False, hint="/rosout, /clock, this page, names with _ and the like"
        )
        for choice in (self._shown, self._arrows, self._space, self._search, self._hidden):
            choice.on_update(self.page.on_node_thread(lambda _event: self._choose()))
        self.keep("show", self._shown)
        self.keep("arrows", self._arrows)
        self.keep("namespace", self._space, has_more=True)
        self.keep("search", self._search)
        self.keep("hidden", self._hidden)
        self._save = self.gui.add_button("Save as SVG")
        self._save.on_click(self.page.on_node_thread(self._send))

    def began(self) -> None:
        """Measure rates again if they are shown; called when a browser shows the panel."""
        self._is_watched = self._is_old = True

    def ended(self) -> None:
        """Unsubscribe from measured topics; called when no browser shows the panel any more."""
        self._is_watched = False
        self._measure(())

    def graph_changed(self) -> None:
        """Mark the drawing as outdated; called when the ROS graph has changed."""
        self._is_old = True

    def _choose(self) -> None:
        self._is_old = True
        self._ticks = _TICKS_BETWEEN_PICTURES

    # --- drawing ------------------------------------------------------------------------------

    def tick(self) -> None:
        """Redraw an outdated graph in another thread, at most once a second; update rates."""
        self._ticks += 1
        if self._ticks % _TICKS_BETWEEN_PICTURES == 0:
            self._show_rates()
        if not self._is_old or self._is_being_drawn or self._ticks < _TICKS_BETWEEN_PICTURES:
            return
        self._is_old, self._is_being_drawn, self._ticks = False, True, 0
        graph = self.page.node.graph()
        self._offer_namespaces({node.namespace for node in graph.nodes})
        shown, include_hidden = _SHOWN[self._shown.value], bool(self._hidden.value)
        arrows, space = self._arrows.value, self._space.value
        text = self._search.value.strip().lower()
        types = {name: kinds[0] for name, kinds in graph.topic_names_and_types() if kinds}
        has_rates = arrows in (_RATES, _BOTH)
        self._measure(sorted(types)[:_MOST_MEASURED] if has_rates else ())
        numbers = {name: number for number, name in enumerate(self._measured)}

        def note(topic: str) -> str:
            kind = types.get(topic, "").replace("/msg/", "/") if arrows in (_TYPES, _BOTH) else ""
            rate = f"{_RATE.format(numbers[topic])} Hz" if topic in numbers else ""
            return "  ".join(filter(None, (kind, rate)))

        def is_wanted(box: DiagramBox) -> bool:
            in_space = space == _ALL or box.text.startswith(space.rstrip("/") + "/")
            return in_space and text in box.text.lower() and (space == _ALL or box.kind == "node")

        def draw() -> tuple[Diagram, str]:
            diagram = ros_graph(graph, shown, include_hidden=include_hidden, note=note)
            if text or space != _ALL:
                diagram = with_neighbours(diagram, is_wanted)
            if len(diagram.boxes) > _MOST_BOXES:
                raise ValueError(
                    f"{len(diagram.boxes)} nodes and topics are too many for a picture: search for "
                    "a name, or choose a namespace. 'teleopctl graph' writes all for Graphviz."
                )
            return diagram, to_svg(diagram, _mark)

        self.page.stage.run_in_background(draw, self._take)

    def _offer_namespaces(self, spaces: set[str]) -> None:
        options = (_ALL, *sorted({*spaces, self._space.value} - {_ALL}))
        if options != tuple(self._space.options):
            chosen = self._space.value
            self._space.options = options
            self._space.value = chosen

    def _take(self, drawn: Any) -> None:
        self._is_being_drawn = False
        if isinstance(drawn, Exception):
            self._diagram, self._svg = None, ""
            content = note_html(escaped_html(str(drawn)))
        elif drawn[1] == self._svg:
            return
        else:
            self._diagram, self._svg = drawn
            # Rates are elements of their own, filled in once a second.
            svg = _RATE_FOUND.sub(r'<tspan id="graph-rate-\1">-</tspan>', self._svg)
            topics = sum(box.kind == "topic" for box in self._diagram.boxes)
            total = len(self.page.node.graph().topic_names_and_types())
            count = f"{topics} of {total} topics." if topics < total else ""
            content = _PICTURE.format(svg=svg, count=count)
            if not self._diagram.boxes:
                content = note_html("No node or topic has such a name.")
        self._picture.content = content
        self._save.visible = bool(self._svg)

    def _send(self, event: Any) -> None:
        if self._diagram is None:
            return
        diagram, client = self._diagram, event.client

        def send(svg: Any) -> None:
            content = self._with_rates(svg).encode()
            client.send_file_download("graph.svg", content, save_immediately=True)

        self.page.stage.run_in_background(partial(to_svg, diagram), send)

    # --- rates --------------------------------------------------------------------------------

    def _measure(self, topics: Any) -> None:
        self._measured = list(topics)
        self._meter.follow(self, self._measured if self._is_watched else ())

    def _rates(self) -> dict[int, str]:
        traffic = self._meter.sample()
        return {
            number: f"{traffic[name].rate_hz:.1f}" if name in traffic else "-"
            for number, name in enumerate(self._measured)
        }

    def _show_rates(self) -> None:
        if self._measured:
            self.page.fill(
                {f"graph-rate-{number:05d}": text for number, text in self._rates().items()}
            )

    def _with_rates(self, svg: str) -> str:
        rates = self._rates()
        return _RATE_FOUND.sub(lambda found: rates.get(int(found[1]), "-"), svg)

    # --- clicks -------------------------------------------------------------------------------

    # Any: viser's handle of a browser.
    def clicked(self, client: Any, what: str) -> None:
        """Open a window about a clicked node or topic, with ways to the panels that show more.

        Args:
            client: viser's handle of the browser.
            what: ``node`` or ``topic``, and the name.
        """
        kind, _, name = what.partition(" ")
        graph = self.page.node.graph()
        if kind == "node":
            ends = [one for one in graph.endpoints if one.full_name == name]
            lists = {
                "publishes": [one.name for one in ends if one.kind.name == "MP"],
                "subscribes to": [one.name for one in ends if one.kind.name == "MS"],
                "serves": [one.name for one in ends if one.kind.name == "SS"],
            }
            panels: tuple[str, ...] = ("Parameters", "Log")
        else:
            types = dict(graph.topic_names_and_types()).get(name, [])
            lists = {
                "of type": types,
                "published by": [one.full_name for one in graph.publishers(name)],
                "subscribed by": [one.full_name for one in graph.subscriptions(name)],
            }
            panels = ("Messages",) if types else ()
        text = "<br>".join(
            _listed(title, names) for title, names in lists.items() if _unique(names)
        )
        with dialog(client, name) as window:
            client.gui.add_html(note_html(text or "It is not in the graph any more."))
            if panels:
                buttons = client.gui.add_button_group(" ", panels)
                buttons.on_click(
                    self.page.on_node_thread(lambda event: self._go(window, name, event))
                )

    def _go(self, window: Any, name: str, event: Any) -> None:
        window.close()
        panel = {"Parameters": "parameters", "Log": "log"}.get(event.target.value, "topics")
        shown = self.page.workspace.bring(event.client.client_id, panel)
        if shown is not None:
            shown.show_of(name)


def _mark(box: DiagramBox) -> str:
    if box.kind == "label":
        return ""
    return click_mark("graph", f"{box.kind} {box.text.partition(chr(10))[0]}")


def _listed(title: str, names: list[str]) -> str:
    unique = _unique(names)
    shown = ", ".join(map(escaped_html, unique[:_MOST_LISTED]))
    more = f" and {len(unique) - _MOST_LISTED} more" if len(unique) > _MOST_LISTED else ""
    return f"<b>{title}</b> {shown}{more}"


def _unique(names: list[str]) -> list[str]:
    """Return the names without duplicates and without what every node has, sorted."""
    return sorted({name for name in names if not is_of_every_node(name)})
