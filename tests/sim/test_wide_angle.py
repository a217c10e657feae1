"""Wide angle cameras: judged by the projection that their lens is named for."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.sim.cameras import renderer as quality
from teleopctl.sim.cameras.messages import new_info
from teleopctl.sim.cameras.renderer import CameraRenderer
from tests.samples import sample
from tests.sim.robots import joint, link, robot
from tests.sim.test_cameras import centres

WIDTH, HEIGHT = 400, 300
# Of red balls 2 m away: degrees from the axis, and around it from the right towards below.
PLACES = ((0, 0), (30, 200), (50, 20), (62, 130), (75, 185), (84, 0), (94, 175))

CUSTOM = """<type>custom</type><custom_function><c1>1.05</c1><c2>4</c2><f>1</f><fun>tan</fun>
  </custom_function><cutoff_angle>3.1415</cutoff_angle>"""


def camera(fov: float, inside: str, kind: str = "wideanglecamera") -> str:
    return f"""<gazebo reference="eye"><sensor name="wide" type="{kind}"><camera name="wide">
      <horizontal_fov>{fov}</horizontal_fov><image><width>{WIDTH}</width><height>{HEIGHT}</height>
      </image><clip><near>0.05</near><far>20</far></clip>{inside}</camera></sensor></gazebo>"""


def in_front(sensor: str) -> RobotModel:
    """A camera 8 m above the ground with balls around it; it looks along x, y is to its left."""
    parts = []
    for number, (from_axis, around) in enumerate(PLACES):
        theta, phi = math.radians(from_axis), math.radians(around)
        x = 2 * math.cos(theta)
        y, z = -2 * math.sin(theta) * math.cos(phi), -2 * math.sin(theta) * math.sin(phi)
        ball = '<visual><geometry><sphere radius="0.06"/></geometry></visual>'
        parts.append(link(f"b{number}", ball))
        parts.append(joint(f"j{number}", "eye", f"b{number}", kind="fixed", xyz=f"{x} {y} {z}"))
        parts.append(f'<gazebo reference="b{number}"><material>Gazebo/Red</material></gazebo>')
    mount = joint("mount", "world", "eye", kind="fixed", xyz="0 0 8")
    return build_model(robot(link("world", ""), link("eye", ""), mount, *parts, sensor))


def seen(model: RobotModel) -> list[tuple[float, float]]:
    """Column and row of each ball in the picture."""
    renderer = CameraRenderer(model, model.cameras, quality.FAST)
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    try:
        renderer.place({})
        renderer.colours("wide", picture)
    finally:
        renderer.close()
    return centres(picture)


def pixel(place: tuple[float, float], radius: Callable[[float], float]) -> tuple[float, float]:
    theta, phi = map(math.radians, place)
    r = radius(theta) * WIDTH / 2
    return (WIDTH - 1) / 2 + r * math.cos(phi), (HEIGHT - 1) / 2 + r * math.sin(phi)


@pytest.mark.parametrize(
    ("fov", "inside", "projection"),
    sample([
        (2.4, "", lambda theta: math.tan(theta / 2)),
        (3.4, "<lens><type>equidistant</type><cutoff_angle>3</cutoff_angle></lens>", float),
        (3.4, "<lens><type>equisolid_angle</type><cutoff_angle>3</cutoff_angle></lens>",
         lambda theta: math.sin(theta / 2)),
        (2.8, "<lens><type>orthographic</type></lens>", math.sin),
        (3.4, f"<lens>{CUSTOM}</lens>", lambda theta: math.tan(theta / 4)),
        (2.2, "<lens><type>gnomonical</type></lens>", math.tan),
    ], 2),
)  # fmt: skip
def test_each_direction_is_seen_where_its_projection_puts_it(
    fov: float, inside: str, projection: Callable[[float], float]
) -> None:
    model = in_front(camera(fov, inside))
    found = seen(model)

    def radius(theta: float) -> float:
        return projection(theta) / projection(fov / 2)

    within = [p for p in PLACES if math.radians(p[0]) < fov / 2 - 0.06]
    pixels = [pixel(place, radius) for place in within]
    inside_picture = [p for p in pixels if 5 < p[0] < WIDTH - 6 and 5 < p[1] < HEIGHT - 6]
    assert len(inside_picture) >= 3
    for wanted in inside_picture:
        assert min(math.dist(wanted, centre) for centre in found) < 1.5
    assert model.warnings == ()


def test_camera_info_has_the_fisheye_that_fits() -> None:
    (wide,) = in_front(camera(3.4, f"<lens>{CUSTOM}</lens>")).cameras
    info = new_info(wide)
    fx, _, cx, _, fy, cy, *_ = info.k

    assert info.distortion_model == "equidistant"
    for place in PLACES:
        theta, phi = map(math.radians, place)
        bent = theta + sum(k * theta ** (2 * n + 3) for n, k in enumerate(info.d))
        wanted = pixel(place, lambda angle: math.tan(angle / 4) / math.tan(3.4 / 8))
        shown = (fx * bent * math.cos(phi) + cx, fy * bent * math.sin(phi) + cy)
        assert shown == pytest.approx(wanted, abs=0.1)


def test_nothing_is_seen_beyond_the_cutoff() -> None:
    lens = "<lens><type>equidistant</type><cutoff_angle>0.8</cutoff_angle></lens>"
    # 30 degrees are seen, 50 are not.
    assert len(seen(in_front(camera(3.4, lens)))) == 2


@pytest.mark.parametrize(
    ("fov", "inside", "words"),
    [
        (3.4, "<lens><type>orthographic</type></lens>", "does not see 3.4 rad"),
        (2, "<lens><type>pancake</type></lens>", "<lens> is of the type 'pancake'"),
        (2, "<lens><type>custom</type><custom_function><fun>cos</fun></custom_function></lens>",
         "<fun> is 'cos'"),
    ],
)  # fmt: skip
def test_a_lens_that_there_is_not_is_refused_in_words(fov: float, inside: str, words: str) -> None:
    with pytest.raises(InvalidDescriptionError, match=words):
        in_front(camera(fov, inside))
