"""What plain words of YAML are in ROS 2, and that nothing but a YAML error comes of bad ones."""

import pytest
import yaml

from teleopctl import ros_yaml


def test_plain_words_are_what_ros_2_takes_them_for():
    text = "[1e-3, -2E+5, 1.5, 12, true, 1.2.3, 2020-01-31, 2020-13-45, 2020-01-31 10:00:00]"
    assert ros_yaml.load(text) == [
        *[0.001, -200000.0, 1.5, 12, True],
        *["1.2.3", "2020-01-31", "2020-13-45", "2020-01-31 10:00:00"],
    ]


@pytest.mark.parametrize("text", ["!!int x", "!!float x", "!!timestamp 2020-13-45", "{a: [}"])
def test_what_cannot_be_read_is_a_yaml_error(text):
    with pytest.raises(yaml.YAMLError):
        ros_yaml.load(text)
