"""The drive page's view moves with a mobile base; that of an arm, and other pages', stay."""

from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.nodes.teleop.drive_page.base_view import BaseView

DRIVE_PAGE, OTHER_PAGE = 1, 2


class Scene:
    """Page with two browsers, and which frame the camera of each follows."""

    def __init__(self, *, is_base, is_open=True, path=None):
        self.frames: dict[int, str] = {}
        self.behind: list[tuple[int, float]] = []
        self.set: list[tuple[str, int]] = []
        viewer: Any = SimpleNamespace(
            server=SimpleNamespace(
                get_clients=lambda: {
                    browser: SimpleNamespace(camera=browser) for browser in (DRIVE_PAGE, OTHER_PAGE)
                },
                clients=SimpleNamespace(is_embedded=lambda browser: browser == DRIVE_PAGE),
            ),
            scene_view=SimpleNamespace(
                followed=lambda browser: self.frames.get(browser, ""),
                follow=self.frames.__setitem__,
                path=path,
                displays=[
                    SimpleNamespace(rviz_class=kind, set=lambda *value: self.set.append(value))
                    for kind in ("Grid", "RobotModel")
                ],
                frame_robot=lambda camera, direction: self.behind.append((camera, direction[0])),
            ),
            create_timer=lambda _, look, clock: setattr(self, "look", look),
        )
        driver: Any = SimpleNamespace(
            is_base=is_base,
            robot_state=SimpleNamespace(description=SimpleNamespace(root="base_footprint")),
        )
        BaseView(viewer, lambda: driver, lambda: is_open)

    look: Any


@pytest.mark.parametrize(
    ("is_base", "is_open", "followed"),
    [
        (True, True, {DRIVE_PAGE: "base_footprint"}),
        (True, False, {}),
        (False, True, {}),
    ],
)
def test_the_view_of_a_drive_page_moves_with_a_base(is_base, is_open, followed):
    scene = Scene(is_base=is_base, is_open=is_open)
    for _ in range(2):
        scene.look()
    assert scene.frames == followed
    # The camera is behind the base, whose x axis is forward.
    assert scene.behind == [(browser, -1.0) for browser in followed]
    assert scene.set == [("Plane Cell Count", 200) for _ in followed]


def test_the_view_of_an_rviz_file_stays_and_moves_with_the_base():
    scene = Scene(is_base=True, path="mine.rviz")
    scene.look()
    assert scene.frames == {DRIVE_PAGE: "base_footprint"}
    assert not scene.behind
    assert not scene.set
