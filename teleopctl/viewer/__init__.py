"""Web page of the robot: RViz displays, joint sliders and rqt tools in a browser.

May import `diagram`, `interfaces`, `node`, `pictures`, `robot` and `tf`, and what every package
may: `base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.viewer.camera_pictures import CameraPictures as CameraPictures
    from teleopctl.viewer.displays.base import (
        ERROR as ERROR,
        OK as OK,
        WARN as WARN,
        Display as Display,
        Stage as Stage,
    )
    from teleopctl.viewer.displays.properties import Property as Property
    from teleopctl.viewer.layout import (
        LayoutError as LayoutError,
        PageLayout as PageLayout,
        layout_of as layout_of,
        load_layout as load_layout,
        presets as presets,
    )
    from teleopctl.viewer.page_routes import PageRoutes as PageRoutes
    from teleopctl.viewer.page_server import (
        PageError as PageError,
        close_server as close_server,
        open_page as open_page,
        open_server as open_server,
        page_address as page_address,
    )
    from teleopctl.viewer.panels.base import Page as Page, Panel as Panel
    from teleopctl.viewer.panels.joint_movers import SLIDERS_TOPIC as SLIDERS_TOPIC
    from teleopctl.viewer.viewer import Viewer as Viewer, open_viewer as open_viewer
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
