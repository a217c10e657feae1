"""Pictures of boxes and arrows, such as the graph of nodes and topics: as SVG or for Graphviz."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.diagram.dot import to_dot as to_dot
    from teleopctl.diagram.files import write_files as write_files
    from teleopctl.diagram.layout import DiagramLayout as DiagramLayout, lay_out as lay_out
    from teleopctl.diagram.model import (
        Diagram as Diagram,
        DiagramBox as DiagramBox,
        Edge as Edge,
        joined as joined,
    )
    from teleopctl.diagram.nodes_and_topics import SHOWN as SHOWN, ros_graph as ros_graph
    from teleopctl.diagram.svg import to_svg as to_svg
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
