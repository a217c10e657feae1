"""However many names of frames somebody makes up, the page holds so many of them."""

from types import SimpleNamespace

import pytest

from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.frames import TfDisplay
from teleopctl.viewer.panels.scene import _Row
from teleopctl.viewer.scene import frames as frames_module
from teleopctl.viewer.scene.frames import LargeTransforms

MOST = 20
UNKNOWN = 5


class World:
    """A page whose time the test makes pass, and those who speak of frames."""

    def __init__(self, page, monkeypatch):
        self.page = page
        self.now_s = 100.0
        clock = SimpleNamespace(monotonic=lambda: self.now_s)
        monkeypatch.setattr(frames_module, "time", clock)
        monkeypatch.setattr(frames_module, "MOST_FRAMES", MOST)
        monkeypatch.setattr(frames_module, "MOST_UNKNOWN", UNKNOWN)
        self.display = TfDisplay(page, "TF", "/tf_display")
        self.display.begin()

    def speak(self, *pairs, static=False):
        """Tell where children stand: ``"parent child"``."""
        buffer = self.page.frames.buffer
        put = buffer.set_transform_static if static else buffer.set_transform
        for pair in pairs:
            parent, child = pair.split()
            put(transform_stamped(parent, child, int(self.now_s * 1e9), Transform()))

    def pass_time(self, seconds):
        """Let time pass, and the picture move on."""
        self.now_s += seconds
        self.page.frames.update()
        self.display.update(jumped_back=False)

    @property
    def known(self):
        return set(self.page.frames.buffer.frame_names())

    @property
    def dressed(self):
        """The frames with axes."""
        return {name for name, one in self.page.frames.by_name.items() if one.node.show_axes}


@pytest.fixture
def world(page, monkeypatch):
    return World(page, monkeypatch)


def test_those_that_are_silent_for_longest_are_forgotten(world):
    world.speak("base sensor", static=True)
    world.speak("map base")
    for number in range(200):
        world.speak("base arm", f"arm object_{number}")
        world.pass_time(1.0)
    assert {"map", "base", "arm", "sensor", "object_199"} <= world.known
    assert "object_0" not in world.known
    assert len(world.known) <= MOST + 1
    assert len(world.page.frames.by_name) <= MOST + 1 + UNKNOWN
    assert world.display.status[0] == WARN
    world.pass_time(100.0)
    assert world.display.status[0] == OK


def test_where_none_is_silent_those_that_were_first_stay(world):
    world.speak("base arm")
    for number in range(1000):
        world.speak(f"base object_{number}")
    world.speak("base arm")
    world.pass_time(1.0)
    assert {"base", "arm", "object_0"} <= world.known
    assert len(world.known) == MOST + 1
    assert world.display.status[0] == WARN


def test_a_frame_that_is_handed_from_parent_to_parent_has_a_bound_too(world):
    for number in range(1000):
        world.speak(f"hand_{number} ball")
        world.pass_time(0.1)
    assert "hand_999" in world.known
    assert len(world.known) <= 2 * MOST + 1
    assert len(world.page.frames.by_name) <= UNKNOWN + 2


def test_a_frame_that_is_silent_while_others_are_not_loses_its_axes(world):
    world.speak("base arm", "arm hand", "base wheel")
    world.pass_time(1.0)
    assert world.dressed == {"base", "arm", "hand", "wheel"}
    for _ in range(20):
        world.pass_time(1.0)
        world.speak("arm hand", "base wheel")
    world.pass_time(1.0)
    # Where the hand is depends on the arm.
    assert world.dressed == {"base", "wheel"}
    world.page.frames.set_fixed_frame("hand")
    world.pass_time(1.0)
    assert world.dressed == {"hand", "arm"}
    world.speak("base arm")
    world.pass_time(1.0)
    assert world.dressed == {"base", "arm", "hand", "wheel"}


def test_where_all_are_silent_all_keep_their_axes(world):
    world.speak("base arm")
    world.speak("arm sensor", static=True)
    world.pass_time(1000.0)
    assert world.dressed == {"base", "arm", "sensor"}


def test_the_list_of_frames_has_those_that_there_are(world):
    row = _Row(world.page, world.display)
    for number in range(100):
        world.speak("base arm", f"arm object_{number}")
        world.pass_time(1.0)
        row.show_status()
    assert set(row._parts) == set(world.page.frames.by_name)


def test_thousands_of_transforms_are_decoded_four_times_a_second(monkeypatch):
    now_s = 100.0
    monkeypatch.setattr("teleopctl.viewer.scene.frames.time.monotonic", lambda: now_s)
    choice = LargeTransforms()
    taken = [choice.is_taken(size) for size in (500, 500, 200_000, 200_000, 300_000)]
    assert taken == [True, True, True, False, True]
    now_s += 0.3
    assert choice.is_taken(200_000)
