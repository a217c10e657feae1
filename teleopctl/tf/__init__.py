"""tf2 in Python: transforms between coordinate frames over time, their buffer and listener.

May import `interfaces` and `node`, and what every package may: `base`, `errors`, `packages` and
`plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.tf.broadcaster import (
        TF_STATIC_TOPIC as TF_STATIC_TOPIC,
        TF_TOPIC as TF_TOPIC,
        StaticTransformBroadcaster as StaticTransformBroadcaster,
        TransformBroadcaster as TransformBroadcaster,
    )
    from teleopctl.tf.buffer import Buffer as Buffer
    from teleopctl.tf.buffer_client import BufferClient as BufferClient
    from teleopctl.tf.buffer_core import BufferCore as BufferCore
    from teleopctl.tf.conversions import (
        BufferInterface as BufferInterface,
        ConvertRegistration as ConvertRegistration,
        NotImplementedException as NotImplementedException,
        Stamped as Stamped,
        TransformRegistration as TransformRegistration,
        TypeException as TypeException,
        convert as convert,
    )
    from teleopctl.tf.echo import (
        echo_text as echo_text,
        echo_transforms as echo_transforms,
    )
    from teleopctl.tf.errors import (
        ConnectivityException as ConnectivityException,
        ExtrapolationException as ExtrapolationException,
        InvalidArgumentException as InvalidArgumentException,
        LookupException as LookupException,
        TimeoutException as TimeoutException,
        TransformException as TransformException,
    )
    from teleopctl.tf.frame_texts import KnownFrame as KnownFrame
    from teleopctl.tf.geometry import (
        do_transform_point as do_transform_point,
        do_transform_polygon_stamped as do_transform_polygon_stamped,
        do_transform_pose as do_transform_pose,
        do_transform_pose_stamped as do_transform_pose_stamped,
        do_transform_pose_with_covariance_stamped as do_transform_pose_with_covariance_stamped,
        do_transform_vector3 as do_transform_vector3,
        register as register,
        transform_covariance as transform_covariance,
    )
    from teleopctl.tf.listener import (
        NamedTransformListener as NamedTransformListener,
        TransformListener as TransformListener,
    )
    from teleopctl.tf.live_buffer import AHEAD_S as AHEAD_S, LiveBuffer as LiveBuffer
    from teleopctl.tf.messages import (
        move_transform as move_transform,
        stamp_of as stamp_of,
        transform_of as transform_of,
        transform_stamped as transform_stamped,
    )
    from teleopctl.tf.monitor import (
        GATHER_S as GATHER_S,
        MonitorResults as MonitorResults,
        monitor_transforms as monitor_transforms,
    )
    from teleopctl.tf.prepared_transforms import PreparedTransforms as PreparedTransforms
    from teleopctl.tf.transforms import (
        ECHO_DIGITS as ECHO_DIGITS,
        Pose7 as Pose7,
        Quaternion as Quaternion,
        Transform as Transform,
        Vector3 as Vector3,
        conjugate as conjugate,
        matrix_from_quaternion as matrix_from_quaternion,
        multiply as multiply,
        normalize as normalize,
        pose_text as pose_text,
        quaternion_from_axis_angle as quaternion_from_axis_angle,
        quaternion_from_rpy as quaternion_from_rpy,
        rotate as rotate,
        rpy_from_quaternion as rpy_from_quaternion,
        slerp as slerp,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
