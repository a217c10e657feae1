"""``<gazebo>``: physics of links, sensors and plug-ins."""

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.gazebo_tag import LinkPhysics
from teleopctl.robot.urdf import Pose


def gazebo(body):
    return RobotDescription.from_urdf(f'<robot name="r"><link name="a"/>{body}</robot>').gazebo


def test_physics_of_a_link_is_read_from_all_its_tags():
    found = gazebo(
        '<gazebo reference="a"><mu1 value="0.2"/><material>Gazebo/Red</material></gazebo>'
        '<gazebo reference="a"><selfCollide value="1"/></gazebo>'
    )
    assert found.links["a"] == LinkPhysics((0.85, 0.1, 0.1, 1.0), 0.2, True)


def test_a_camera_has_sensible_defaults():
    (sensor,) = gazebo(
        '<gazebo reference="a"><sensor name="eye" type="camera"><pose>1 2 3 0 0.5 0</pose>'
        '<camera name="c"><horizontal_fov>1.5</horizontal_fov><image><width>64</width>'
        "<height>48</height></image></camera></sensor></gazebo>"
    ).sensors
    assert sensor.pose == Pose((1, 2, 3), (0, 0.5, 0))
    assert (sensor.camera.width, sensor.camera.height) == (64, 48)
    assert (sensor.camera.near, sensor.camera.far) == (0.1, 100.0)


def test_plugins_of_the_robot_keep_all_their_settings():
    (plugin,) = gazebo(
        '<gazebo><plugin name="n" filename="lib.so"><parameters>a.yaml</parameters>'
        "<parameters>b.yaml</parameters><ros><namespace>/x</namespace></ros></plugin></gazebo>"
    ).plugins
    assert plugin.parameters["parameters"] == ("a.yaml", "b.yaml")
    assert plugin.parameter("ros/namespace") == "/x"
    assert plugin.parameter("none", "default") == "default"


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<mu1>much</mu1>", "<mu1> should be a number, got 'much'"),
        ("<selfCollide>maybe</selfCollide>", "should be true or false, got 'maybe'"),
        ("<mu1>-1</mu1>", "<mu1> should not be negative, got -1"),
        ('<sensor name="s" type="camera"><camera/></sensor>', "needs an <image>"),
        (
            '<sensor name="s" type="camera"><camera><image/></camera></sensor>',
            "has no <horizontal_fov>",
        ),
        ('<sensor name="s" type="ray"><pose>1 2 3</pose></sensor>', "should be 6 finite numbers"),
    ],
)
def test_mistakes_are_named(inside, message):
    with pytest.raises(TeleopctlError, match=message):
        gazebo(f'<gazebo reference="a">{inside}</gazebo>')
