"""Diagrams of boxes and arrows, such as the graph of nodes and topics, as SVG or for Graphviz.

May import `wire`, and what every package may: `base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.diagram.files import (
        format_dot as format_dot,
        to_svg as to_svg,
        write_diagram_files as write_diagram_files,
    )
    from teleopctl.diagram.layout import (
        Diagram as Diagram,
        DiagramBox as DiagramBox,
        DiagramLayout as DiagramLayout,
        Edge as Edge,
        connect as connect,
        lay_out as lay_out,
    )
    from teleopctl.diagram.nodes_and_topics import (
        SHOWN as SHOWN,
        ros_graph as ros_graph,
        with_neighbours as with_neighbours,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
