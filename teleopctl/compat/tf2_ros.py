"""``tf2_ros`` for programs that import it: transforms with their familiar names."""

from teleopctl.tf.broadcaster import (
    StaticTransformBroadcaster as StaticTransformBroadcaster,
)
from teleopctl.tf.broadcaster import TransformBroadcaster as TransformBroadcaster
from teleopctl.tf.buffer import Buffer as Buffer
from teleopctl.tf.errors import ConnectivityException as ConnectivityException
from teleopctl.tf.errors import ExtrapolationException as ExtrapolationException
from teleopctl.tf.errors import InvalidArgumentException as InvalidArgumentException
from teleopctl.tf.errors import LookupException as LookupException
from teleopctl.tf.errors import TimeoutException as TimeoutException
from teleopctl.tf.errors import TransformException as TransformException
from teleopctl.tf.listener import TransformListener as TransformListener
