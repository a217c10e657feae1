"""``tf2_geometry_msgs``: points, vectors and poses in another frame."""

from teleopctl.tf.geometry import (
    do_transform_point as do_transform_point,
)
from teleopctl.tf.geometry import (
    do_transform_polygon_stamped as do_transform_polygon_stamped,
)
from teleopctl.tf.geometry import (
    do_transform_pose as do_transform_pose,
)
from teleopctl.tf.geometry import (
    do_transform_pose_stamped as do_transform_pose_stamped,
)
from teleopctl.tf.geometry import (
    do_transform_pose_with_covariance_stamped as do_transform_pose_with_covariance_stamped,
)
from teleopctl.tf.geometry import (
    do_transform_vector3 as do_transform_vector3,
)
from teleopctl.tf.geometry import register
from teleopctl.tf.geometry import transform_covariance as transform_covariance

register()
