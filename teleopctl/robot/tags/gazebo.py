"""Tags of ``<gazebo>`` in a URDF, for links, joints and robots, and of ``<sensor>`` by its type.

Gazebo copies the content of a ``<gazebo>`` for a link or joint to the SDF link or joint, so SDF's
tags are allowed as well.
"""

from __future__ import annotations

from functools import cache

from teleopctl.robot.sensor_tag import WIDE_ANGLE_TYPES
from teleopctl.robot.tags.sdf import SURFACE
from teleopctl.robot.tags.table import Table

_STIFF = "contacts are as stiff as steps of physics allow, and DART does not read it"
# Gazebo reads a value from the text or from this attribute.
_VALUE = ("value",)

OF_LINKS = Table(
    SURFACE.format("collision*/")
    + f"""
    + .: @reference material mu1 mu2 selfCollide self_collide gravity turnGravityOff
    + material: diffuse ambient script/name
    * material: specular emissive shininess shader script/uri lighting=true=1
    * material/script: uri
    - material: pbr
    - visual/material: pbr
    + visual/material: diffuse ambient script/name
    * visual/material: specular emissive shininess shader script/uri lighting=true=1
    > .: sensor*@name@type plugin*@name@filename fdir1
    + .: collision*@name
    * collision: max_contacts
    - collision: pose geometry laser_retro density
    * .: maxContacts max_contacts maxVel max_vel minDepth min_depth genTexCoord
    * visual: cast_shadows=true=1 meta visibility_flags=4294967295 laser_retro
    - visual: transparency geometry pose plugin
    - .: kp=1e12 kd=1 | {_STIFF}
    - .: dampingFactor laserRetro laser_retro static=false=0 kinematic=false=0 velocity_decay
    - .: enable_wind=false=0 inertial light projector battery particle_emitter pose
    - .: audio_sink audio_source must_be_base_link=false=0
    """,
    _VALUE,
)
OF_JOINTS = Table(
    """
    + .: @reference springStiffness springReference
    > .: sensor*@name@type plugin*@name@filename
    * .: implicitSpringDamper provideFeedback provide_feedback preserveFixedJoint stopCfm stopErp
    * .: disableFixedJointLumping disableJointLumping cfmDamping fudgeFactor stopKp stopKd physics
    - .: initial_joint_position initialJointPosition axis pose mechanicalReduction
    """,
    _VALUE,
)
OF_ROBOTS = Table(
    """
    + .: @reference static
    + .: joint*@name@type
    + joint: parent child pose axis/xyz
    * joint: physics
    - joint: axis2 sensor gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch
    - joint/axis: limit dynamics initial_position use_parent_model_frame=false=0
    > .: plugin*@name@filename
    * .: allow_auto_disable=true=1
    - .: self_collide=true=1 enable_wind=false=0 pose link model include frame light gripper
    """,
    _VALUE,
)

_NOISE = """
    - {}/noise: @type=none=gaussian=gaussian_quantized type=none=gaussian=gaussian_quantized
    + {}/noise: mean stddev bias_mean bias_stddev dynamic_bias_stddev
    + {}/noise: dynamic_bias_correlation_time precision
"""
_OF_ALL = """
    + .: @name @type update_rate frame_id gz_frame_id ignition_frame_id pose topic
    > .: plugin*@name@filename
    * .: visualize=false=0 always_on=true=1 enable_metrics=false=0
    - pose: @relative_to @frame @rotation_format=euler_rpy
    - .: parent origin
"""
_RAYS = """
    + {0}/scan/horizontal: samples resolution min_angle max_angle
    + {0}/scan/vertical: samples resolution min_angle max_angle
    + {0}/range: min max
    * {0}/range: resolution
    - {0}: visibility_mask=4294967295
"""
_CAMERA = """
    + camera: @name horizontal_fov camera_info_topic optical_frame_id
    + camera/image: width height
    - camera/image: format=r8g8b8=rgb_int8=b8g8r8=bgr_int8=l8=l_int8
    * camera/image: anti_aliasing
    * camera: vertical_fov
    + camera/clip: near far
    + camera/distortion: k1 k2 k3 p1 p2
    - camera/distortion: center=0.5_0.5
    + camera/lens/intrinsics: fx fy cx cy
    - camera/lens/intrinsics: s
    + camera/lens/projection: p_fx p_fy p_cx p_cy tx ty
    - camera/lens: type=gnomonic=stereographic scale_to_hfov=true=1 custom_function cutoff_angle
    - camera/lens: env_texture_size
    + .: optical_frame_id
    - camera: pose segmentation_type box_type save depth_camera visibility_mask=4294967295
    - camera: triggered=false=0 trigger_topic
"""
_WIDE_ANGLE = """
    + camera/lens: type scale_to_hfov cutoff_angle custom_function
    + camera/lens/custom_function: c1 c2 c3 f fun
    * camera/lens: env_texture_size
    - camera/lens/intrinsics: fx fy cx cy
    - camera/distortion: k1 k2 k3 p1 p2
"""
_NOISES = {
    "imu": [f"imu/{what}/{axis}" for what in ("angular_velocity", "linear_acceleration")
            for axis in "xyz"],
    "force_torque": [f"force_torque/{what}/{axis}" for what in ("force", "torque")
                     for axis in "xyz"],
    "touch": ["touch"],
    "mujoco": ["mujoco"],
    "rangefinder": ["rangefinder"],
    "sonar": ["sonar"],
    "magnetometer": [f"magnetometer/{axis}" for axis in "xyz"],
    "altimeter": ["altimeter/vertical_position", "altimeter/vertical_velocity"],
    "air_pressure": ["air_pressure/pressure"],
}  # fmt: skip
_OWN = {
    "imu": """
    + imu: enable_orientation
    - imu: noise topic
    - imu/orientation_reference_frame: localization=ENU=NED=NWU=CUSTOM grav_dir_x
    + imu/orientation_reference_frame: custom_rpy
    - imu/orientation_reference_frame/custom_rpy: @parent_frame=world
    - imu/orientation_reference_frame/grav_dir_x: @parent_frame
    """,
    "force_torque": "+ force_torque: frame measure_direction",
    "touch": "+ touch: sensor",
    "mujoco": "+ mujoco: sensor message",
    "rangefinder": "+ rangefinder: sensor",
    "sonar": "+ sonar: min max radius\n- sonar: geometry=cone",
    "contact": "+ contact: collision* topic",
    "air_pressure": "+ air_pressure: reference_altitude",
}
_RAY_TYPES = ("ray", "gpu_ray", "lidar", "gpu_lidar")


def _noise(path: str) -> str:
    return _NOISE.format(path, path, path)


@cache
def of_sensors(kind: str) -> Table:
    """Return the table of the tags that a sensor type may have.

    Args:
        kind: Type of the sensor; unlisted types have the tags of cameras.
    """
    text = _OF_ALL + _OWN.get(kind, "")
    if kind in _RAY_TYPES:
        # Gazebo accepts either tag for rays, whatever the type.
        text += "".join(_RAYS.format(tag) + _noise(tag) for tag in ("ray", "lidar"))
    elif kind in ("gps", "navsat"):
        paths = [f"{kind}/{what}_sensing/{way}" for what in ("position", "velocity")
                 for way in ("horizontal", "vertical")]  # fmt: skip
        text += "".join(_noise(path) for path in paths)
    elif kind in _NOISES:
        text += "".join(_noise(path) for path in _NOISES[kind])
    elif kind not in _OWN:
        text += _CAMERA + _noise("camera")
        if kind in WIDE_ANGLE_TYPES:
            text += _WIDE_ANGLE
        if kind in ("boundingbox", "boundingbox_camera"):
            text += "- camera: box_type=2d=visible_2d=visible_box_2d"
        if kind in ("depth", "depth_camera"):
            text += "- camera/image: format=r_float32=float32=r8g8b8=rgb_int8"
    return Table(text, _VALUE)
