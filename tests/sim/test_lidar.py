"""Lidars, sonars and their noise: judged by the geometry around them."""

import math

import numpy as np
import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.mujoco_model import NewObject, with_objects, without_objects
from teleopctl.robot import Noise, read_world_text
from teleopctl.sim.sensors.noise import NoiseSource
from tests.sim.robots import box, joint, link
from tests.sim.test_sensors import Measured, gazebo

# A room of walls 0.2 m thick: ahead at 2 m, behind at 1 m, to the left at 3 m; a plane below.
WALLS = {"ahead": ("0.2 9 9", "2.1 0 1"), "behind": ("0.2 9 9", "-1.1 0 1")} | {
    "left": ("9 0.2 9", "0 3.1 1")
}
ROOM = "".join(
    link(name, box("visual", size) + box("collision", size))
    + joint(f"to_{name}", "base", name, kind="fixed", xyz=xyz)
    for name, (size, xyz) in WALLS.items()
)


def scan(count: int, first: float, last: float, rest: str = "", rings: str = "") -> str:
    return f"""<ray><scan><horizontal><samples>{count}</samples><min_angle>{first}</min_angle>
      <max_angle>{last}</max_angle></horizontal>{rings}</scan>
      <range><min>0.1</min><max>10</max></range>{rest}</ray><update_rate>10</update_rate>"""


def looking(
    content: str, kind: str = "gpu_lidar", *, housing: str = "", more: str = ""
) -> Measured:
    """A lidar in the room, 1 m above the ground."""
    mount = joint("mount", "base", "eye", kind="fixed", xyz="0 0 1")
    eye = gazebo("eye", content, kind)
    return Measured(link("base", ""), ROOM, link("eye", housing), mount, eye, more)


def read(measured: Measured, index: int = 0):
    sensor = measured.sensors[index]
    message = get_message(sensor.message_type)()
    sensor.read(*measured.simulation.observe(), message)
    return message


def points(message) -> np.ndarray:
    """Coordinates, (rings, columns, 3)."""
    raw = np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, -1)
    return np.ascontiguousarray(raw[..., :12]).view("<f4").astype(float)


def test_a_scan_has_the_distances_of_the_walls_and_is_infinite_where_nothing_is() -> None:
    quarter = math.pi / 2
    message = read(looking(scan(5, -math.pi, math.pi)))

    assert list(message.ranges) == pytest.approx([1, math.inf, 2, 3, 1], abs=1e-6)
    assert (message.angle_min, message.angle_max) == pytest.approx((-math.pi, math.pi))
    assert message.angle_increment == pytest.approx(quarter)
    assert (message.range_min, message.range_max) == pytest.approx((0.1, 10.0))


@pytest.mark.parametrize("kind", ["gpu_lidar", "ray"])
def test_what_comes_is_seen_where_it_is_and_no_more_when_it_has_left(kind: str) -> None:
    """By what is drawn and by what collides alike."""
    measured = looking(scan(3, -0.1, 0.1), kind)
    simulation = measured.simulation
    assert list(read(measured).ranges)[1] == pytest.approx(2.0, abs=1e-6)
    post = read_world_text("things: {post: {shape: box, size: [0.2, 0.2, 4]}}", "text")
    for x in (1.0, 0.6):
        place, turn = np.array([x, 0.0, 1.0]), np.array([1.0, 0.0, 0.0, 0.0])
        simulation.replace_model(
            with_objects(simulation.model, [NewObject(post, f"post{x}", place, turn)])
        )
        assert list(read(measured).ranges)[1] == pytest.approx(x - 0.1, abs=1e-6)
    # What stood there is put elsewhere, out of its way.
    simulation.set_static_pose("post0.6", np.array([-4.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    simulation.refresh()
    assert list(read(measured).ranges)[1] == pytest.approx(0.9, abs=1e-6)
    simulation.replace_model(without_objects(simulation.model, ["post1.0", "post0.6"]))
    assert list(read(measured).ranges)[1] == pytest.approx(2.0, abs=1e-6)


def test_points_of_rings_lie_on_what_the_rays_meet() -> None:
    angles = "<min_angle>-0.6</min_angle><max_angle>0.6</max_angle>"
    down = f"<vertical><samples>3</samples>{angles}</vertical>"
    measured = looking(scan(4, -0.3, 0.3, rings=down))
    message = read(measured, 1)
    cloud = points(message)

    assert [sensor.topic for sensor in measured.sensors] == ["sensor", "sensor/points"]
    assert [field.name for field in message.fields] == ["x", "y", "z", "intensity", "ring"]
    assert (message.height, message.width, message.is_dense) == (3, 4, True)
    # The lowest ring meets the ground 1 m below before the wall at 2 m.
    assert cloud[0, :, 2] == pytest.approx(-1.0, abs=1e-5)
    assert cloud[1:, :, 0] == pytest.approx(2.0, abs=1e-5)
    flat = read(measured)
    assert list(flat.ranges) == pytest.approx(np.linalg.norm(cloud[1], axis=-1), abs=1e-5)


def test_a_lidar_looks_out_of_its_housing_and_past_what_is_too_near_but_sees_its_robot() -> None:
    housing = box("visual", "0.4 0.4 0.4") + box("visual", "0.02 0.3 0.3", "0.05 0 0")
    mast = link("mast", box("visual", "0.1 0.1 4")) + joint(
        "to_mast", "eye", "mast", kind="fixed", xyz="0 0.6 0"
    )
    message = read(looking(scan(3, -math.pi, math.pi / 2), housing=housing, more=mast))

    assert list(message.ranges) == pytest.approx([1, 2 * math.sqrt(2), 0.55], abs=1e-6)
    ahead = read(looking(scan(1, 0, 0), housing=housing))
    assert list(ahead.ranges) == pytest.approx([2.0], abs=1e-6)


def test_a_ray_meets_what_collides_and_a_gpu_lidar_what_is_drawn() -> None:
    only_seen = link("veil", box("visual", "0.02 1 1")) + joint(
        "to_veil", "eye", "veil", kind="fixed", xyz="1 0 0"
    )
    drawn = read(looking(scan(1, 0, 0), more=only_seen))
    plugin = """<plugin name="p" filename="libgazebo_ros_ray_sensor.so">
      <output_type>sensor_msgs/LaserScan</output_type></plugin>"""
    solid = read(looking(scan(1, 0, 0) + plugin, "ray", more=only_seen))

    assert drawn.ranges[0] == pytest.approx(0.99, abs=1e-6)
    assert solid.ranges[0] == pytest.approx(2.0, abs=1e-6)


@pytest.mark.parametrize(
    ("plugin", "kind", "topic", "type_"),
    [
        ("<ros><argument>~/out:=scan</argument></ros><output_type>sensor_msgs/LaserScan"
         "</output_type>", "ray", "scan", "LaserScan"),
        ("<ros><namespace>/front</namespace></ros>", "gpu_ray", "/front/p/out", "PointCloud2"),
        ("<ros><namespace>a</namespace><remapping>~/out:=range</remapping></ros>"
         "<output_type>sensor_msgs/Range</output_type>", "ray", "/a/range", "Range"),
    ],
)  # fmt: skip
def test_gazebos_plugin_decides_topic_and_message(
    plugin: str, kind: str, topic: str, type_: str
) -> None:
    plugin = f'<plugin name="p" filename="libgazebo_ros_ray_sensor.so">{plugin}</plugin>'
    (sensor,) = looking(scan(3, -0.1, 0.1) + plugin, kind).sensors

    assert (sensor.topic, sensor.message_type) == (topic, f"sensor_msgs/msg/{type_}")


# Gazebo's sonars look along -z: this one ahead.
SONAR = """<pose>0 0 0 0 -1.5707963 0</pose>
  <sonar><min>0.1</min><max>4</max><radius>{}</radius></sonar>"""


def test_a_sonar_measures_the_nearest_thing_in_its_cone() -> None:
    message = read(looking(SONAR.format(2), "sonar"))

    assert message.range == pytest.approx(2.0, abs=1e-6)
    assert message.field_of_view == pytest.approx(2 * math.atan(0.5))
    assert (message.min_range, message.max_range) == pytest.approx((0.1, 4.0))
    below = SONAR.format(1).replace("-1.5707963", "0")
    assert read(looking(below, "sonar")).range == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("place", "seen"),
    [
        ("1 0 0", True),
        # 14 degrees from the axis are within, 19 beside; so are those above and to the left.
        ("1 0 0.25", True),
        ("1 0.34 0", False),
        ("1 0.25 0.25", False),
    ],
)
def test_a_sonars_cone_is_round_and_misses_nothing_that_is_a_few_centimetres_wide(
    place: str, seen: bool
) -> None:
    post = link("post", box("visual", "0.04 0.04 0.04") + box("collision", "0.04 0.04 0.04"))
    x, y, z = map(float, place.split())
    more = post + joint("to_post", "base", "post", kind="fixed", xyz=f"{x} {y} {z + 1}")
    # atan(1.2 / 4) is 17 degrees.
    distance = read(looking(SONAR.format(1.2), "sonar", more=more)).range

    assert (distance < 1.2) is seen


def test_a_lidar_without_rays_or_with_far_too_many_is_refused_in_words() -> None:
    assert looking("").warnings == [
        "Sensor 'sensor' on link 'eye' (line 5) is left out: it has no <ray> or <lidar>"
    ]
    with pytest.raises(Exception, match="rays are too many"):
        looking(scan(10**12, 0, 1))


def test_noise_has_its_deviation_and_repeats_with_the_seed_whoever_has_listened() -> None:
    noise = Noise(mean=0.5, stddev=0.02)
    source = NoiseSource(noise, 7, "lidar", 0.1)
    values = source.add_noise(np.full(20_000, 3.0), 1.0)

    assert values.mean() == pytest.approx(3.5, abs=6e-4)
    assert values.std() == pytest.approx(0.02, rel=0.02)
    late = NoiseSource(noise, 7, "lidar", 0.1).add_noise(np.full(20_000, 3.0), 1.0)
    assert np.array_equal(values, late)
    for other in (NoiseSource(noise, 8, "lidar", 0.1), NoiseSource(noise, 7, "sonar", 0.1)):
        assert not np.array_equal(values, other.add_noise(np.full(20_000, 3.0), 1.0))
    assert not np.array_equal(values, source.add_noise(np.full(20_000, 3.0), 1.1))


def test_a_wandering_bias_has_its_deviation_and_is_the_same_for_who_begins_late() -> None:
    noise = Noise(dynamic_bias_stddev=0.3, dynamic_bias_correlation_time=0.5)
    source = NoiseSource(noise, 1, "gyro", 0.01)
    zero = np.zeros(3)
    walk = np.array([source.add_noise(zero, 0.01 * step) for step in range(20_001)])

    assert walk.std() == pytest.approx(0.3, rel=0.1)
    correlation = (walk[50:] * walk[:-50]).mean() / walk.var()
    assert correlation == pytest.approx(math.exp(-1.0), abs=0.08)
    late = NoiseSource(noise, 1, "gyro", 0.01)
    assert np.array_equal(late.add_noise(zero, 200.0), walk[-1])
    # A reset begins anew.
    assert np.array_equal(source.add_noise(zero, 0.05), walk[5])


def test_noise_on_a_scan_stays_within_its_range_and_where_nothing_is() -> None:
    noise = "<noise><type>gaussian</type><stddev>0.01</stddev></noise>"
    measured = looking(scan(2001, -math.pi, math.pi, rest=noise))
    once, again = np.array(read(measured).ranges), np.array(read(measured).ranges)
    exact = np.array(read(looking(scan(2001, -math.pi, math.pi))).ranges)

    assert np.array_equal(once, again)
    assert np.array_equal(np.isfinite(once), np.isfinite(exact))
    met = np.isfinite(exact)
    error = once[met] - exact[met]
    assert error.std() == pytest.approx(0.01, rel=0.05)


def test_a_velodynes_plugin_says_what_it_sees_and_how_well() -> None:
    plugin = """<plugin name="p" filename="libgazebo_ros_velodyne_laser.so">
      <min_range>1.5</min_range><max_range>2.5</max_range><gaussianNoise>0.1</gaussianNoise></plugin>"""
    cloud = read(looking(scan(5, -math.pi, math.pi) + plugin, "ray"))
    seen = [float(np.linalg.norm(point)) for point in points(cloud)[0]]

    # The walls at 1 m and 3 m are out of its reach.
    assert [math.isfinite(distance) for distance in seen] == [False, False, True, False, False]
    assert 0.0 < abs(seen[2] - 2.0) < 0.5
