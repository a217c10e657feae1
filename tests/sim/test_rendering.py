"""Pictures: what they show, and which quality is chosen."""

import ctypes
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import cast

import numpy as np
import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.mujoco_model.cameras import CameraModel
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.sim import gl_backend
from teleopctl.sim.cameras import renderer as quality
from teleopctl.sim.cameras.renderer import CameraRenderer, Quality
from tests.sim.robots import box, joint, link, robot

WIDTH, HEIGHT = 160, 120
# For what makes no picture.
NO_MODEL = cast(RobotModel, None)

CAMERA = f"""<gazebo reference="eye"><sensor name="eye" type="camera"><camera name="eye">
  <horizontal_fov>1.2</horizontal_fov>
  <image><width>{WIDTH}</width><height>{HEIGHT}</height></image></camera></sensor></gazebo>"""


def coloured(name: str, colour: str) -> str:
    return link(name, box("visual", "0.4 0.4 0.4")) + (
        f'<gazebo reference="{name}"><material>Gazebo/{colour}</material></gazebo>'
    )


@pytest.fixture(scope="module")
def scene() -> RobotModel:
    """Red to the left and up, blue to the right and down, seen by an eye that looks along x."""
    return build_model(
        robot(
            link("world", ""), link("eye", ""), coloured("red", "Red"), coloured("blue", "Blue"),
            joint("j1", "world", "eye", kind="fixed", xyz="0 0 2"),
            joint("j2", "world", "red", kind="fixed", xyz="3 0.8 2.6"),
            joint("j3", "world", "carriage", kind="prismatic", xyz="3 -0.8 1.4", axis="0 1 0",
                  limit='lower="0" upper="2" effort="1" velocity="1"'),
            link("carriage"), joint("j4", "carriage", "blue", kind="fixed", xyz="0 0 0"),
            CAMERA,
        )
    )  # fmt: skip


class Eye:
    """What the camera of a scene sees."""

    def __init__(self, scene: RobotModel, how: Quality) -> None:
        self.renderer = CameraRenderer(scene, scene.cameras, how)
        self.image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)

    def draw(self, *pose: Mapping[str, float] | Mapping[str, Sequence[float]]) -> None:
        self.renderer.place(*pose)  # type: ignore[arg-type]
        self.renderer.colours("eye", self.image)


@pytest.fixture
def eye(scene: RobotModel) -> Iterator[Eye]:
    made = Eye(scene, quality.FULL)
    yield made
    made.renderer.close()


def test_a_free_body_is_drawn_where_it_is() -> None:
    free = joint("free", "world", "red", kind="floating", xyz="3 0 2", limit="")
    eye = joint("j1", "world", "eye", kind="fixed", xyz="0 0 2")
    scene = build_model(
        robot(link("world", ""), link("eye", ""), eye, coloured("red", "Red"), free, CAMERA)
    )
    seen = Eye(scene, quality.FAST)
    seen.draw({}, {"red": (3.0, 0.8, 2.6, 1.0, 0.0, 0.0, 0.0)})
    column, row = centre_of(seen.image, 0)
    seen.renderer.close()

    assert column < WIDTH / 2 - 10
    assert row < HEIGHT / 2 - 10


def centre_of(picture: np.ndarray, channel: int) -> tuple[float, float]:
    others = [other for other in range(3) if other != channel]
    picture = picture.astype(int)
    strong = picture[..., channel] > 60 + picture[..., others].max(axis=-1)
    assert strong.any()
    rows, columns = np.nonzero(strong)
    return float(columns.mean()), float(rows.mean())


def test_left_is_left_and_up_is_up(eye: Eye) -> None:
    eye.draw({})

    red_column, red_row = centre_of(eye.image, 0)
    assert red_column < WIDTH / 2 and red_row < HEIGHT / 2


def test_the_intrinsics_say_where_a_point_appears(scene: RobotModel, eye: Eye) -> None:
    eye.draw({})

    f, _, cx, _, _, cy, *_ = scene.camera("eye").intrinsics
    column, row = centre_of(eye.image, 0)
    # Its front face is 2.8 m away, 0.8 m to the left and 0.6 m up.
    assert (column, row) == pytest.approx((cx - f * 0.8 / 2.8, cy - f * 0.6 / 2.8), abs=4.0)


def test_a_pose_moves_what_it_moves(eye: Eye) -> None:
    eye.draw({"j3": 0.0})
    at_rest, _ = centre_of(eye.image, 2)
    eye.draw({"j3": 0.5, "a joint of someone else": 1.0})
    moved, _ = centre_of(eye.image, 2)

    assert moved < at_rest - 10


class FakeRenderer:
    """Takes as long for a frame as its quality says."""

    seconds: dict[str, float]
    now = 0.0
    closed: list[str]

    def __init__(self, model, cameras, quality) -> None:
        self.quality = quality

    def place(self, positions) -> None:
        pass

    def colours(self, camera, image) -> None:
        FakeRenderer.now += self.seconds[self.quality.name]

    def close(self) -> None:
        self.closed.append(self.quality.name)


@pytest.mark.parametrize(
    ("milliseconds", "chosen", "verdict"),
    [
        ((5, 4, 3, 2), "full", "holds 30 Hz"),
        ((216, 179, 75, 20), "fast", "holds 30 Hz"),
        ((100, 90, 20, 10), "medium", "holds 30 Hz"),
        ((999, 400, 300, 200), "fast", "is too slow for 30 Hz"),
    ],
)
def test_auto_takes_the_best_quality_that_holds_the_rate(
    monkeypatch: pytest.MonkeyPatch, milliseconds: tuple[int, ...], chosen: str, verdict: str
) -> None:
    qualities = ("full", "high", "medium", "fast")
    monkeypatch.setattr(quality, "CameraRenderer", FakeRenderer)
    FakeRenderer.seconds = {q: ms / 1e3 for q, ms in zip(qualities, milliseconds, strict=True)}
    FakeRenderer.closed = []
    camera = CameraModel("c", "l", "f", 4, 4, 1.0, 30.0)

    made, sentence = quality.make_renderer(NO_MODEL, [camera], "auto", lambda: FakeRenderer.now)

    assert made.quality.name == chosen
    assert verdict in sentence and f"quality {chosen}" in sentence
    assert FakeRenderer.closed == list(qualities[: qualities.index(chosen)])


def test_an_unknown_quality_names_those_there_are() -> None:
    camera = CameraModel("c", "l", "f", 4, 4, 1.0, 30.0)
    with pytest.raises(TeleopctlError) as caught:
        quality.make_renderer(NO_MODEL, [camera], "best")

    assert caught.value.hint == "Expected one of auto, fast, full"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="others have their own OpenGL")
@pytest.mark.parametrize(
    ("installed", "chosen"),
    [({"libEGL.so.1", "libOSMesa.so.8"}, "egl"), ({"libOSMesa.so.8"}, "osmesa")],
)
def test_the_backend_is_what_the_machine_has(
    monkeypatch: pytest.MonkeyPatch, installed: set[str], chosen: str
) -> None:
    pretend(monkeypatch, installed)

    assert gl_backend.choose_backend() == chosen


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="others have their own OpenGL")
def test_a_machine_without_opengl_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    pretend(monkeypatch, set())

    with pytest.raises(TeleopctlError) as caught:
        gl_backend.choose_backend()

    assert caught.value.exit_status == 1
    assert "libegl1 libgl1-mesa-dri" in str(caught.value.hint) and "libosmesa6" in str(
        caught.value.hint
    )


def test_the_users_choice_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "osmesa")

    assert gl_backend.choose_backend() == "osmesa"


def test_a_backend_is_chosen_before_mujoco_is_imported_or_not_at_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "")

    with pytest.raises(RuntimeError, match="mujoco was imported before"):
        gl_backend.choose_backend()


def test_the_camera_imports_mujoco_only_after_the_choice() -> None:
    program = "import sys, teleopctl.nodes.camera; sys.exit('mujoco' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


def pretend(monkeypatch: pytest.MonkeyPatch, installed: set[str]) -> None:
    def load(name: str) -> None:
        if name not in installed:
            raise OSError(name)

    # Set first, so that what the test changes is put back afterwards.
    monkeypatch.setenv("MUJOCO_GL", "")
    monkeypatch.setattr(ctypes, "CDLL", load)
    monkeypatch.delitem(sys.modules, "mujoco")
