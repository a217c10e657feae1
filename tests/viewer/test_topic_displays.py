"""Displays that come by themselves with a topic."""

from teleopctl.viewer.topic_displays import display_of

CLOUD, SCAN = ["sensor_msgs/msg/PointCloud2"], ["sensor_msgs/msg/LaserScan"]
IMAGE, INFO = ["sensor_msgs/msg/Image"], ["sensor_msgs/msg/CameraInfo"]


def kind(topic, topics):
    display = display_of(topic, topics)
    return None if display is None else display.rviz_class


def test_clouds_scans_and_depth_images_have_displays():
    topics = {
        "/front/points": CLOUD,
        "/scan": SCAN,
        "/hand/depth/image_rect_raw": IMAGE,
        "/hand/depth/camera_info": INFO,
        "/image_raw": IMAGE,
        "/camera_info": INFO,
    }
    assert {topic: kind(topic, topics) for topic in topics} == {
        "/front/points": "PointCloud2",
        "/scan": "LaserScan",
        "/hand/depth/image_rect_raw": "DepthCloud",
        "/hand/depth/camera_info": None,
        "/image_raw": None,
        "/camera_info": None,
    }


def test_a_depth_image_with_its_cloud_beside_it_is_drawn_once():
    topics = {
        "/front/depth_image": IMAGE,
        "/front/camera_info": INFO,
        "/front/points": CLOUD,
        "/depth": IMAGE,
        "/depth/points": CLOUD,
        "/lone/depth": IMAGE,
    }
    assert kind("/front/depth_image", topics) is None
    assert kind("/depth", topics) is None
    # Without a CameraInfo its points cannot be placed.
    assert kind("/lone/depth", topics) is None
