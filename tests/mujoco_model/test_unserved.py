"""What a description asks for and does not get is said, and nothing else."""

import pytest

from teleopctl.mujoco_model import gazebo_only_tags, unsupported_tags
from teleopctl.mujoco_model.model import build_model
from teleopctl.robot import RobotDescription
from tests.sim.robots import link, model, robot
from tests.system.sim_partner import teleop_urdf


def warnings(tags: str) -> tuple[str, ...]:
    return model(link("base", ""), link("tip", ""), MOUNT, tags).warnings


MOUNT = '<joint name="mount" type="fixed"><parent link="base"/><child link="tip"/></joint>'
IMAGE = "<image><width>8</width><height>8</height></image>"


def camera(inside: str = "", beside: str = "") -> str:
    return f"""<gazebo reference="tip"><sensor name="eye" type="camera"><camera>
      <horizontal_fov>1</horizontal_fov>{IMAGE}
{inside}</camera>
{beside}</sensor></gazebo>"""


def test_each_kind_of_tag_is_told_once_with_its_lines() -> None:
    tags = """
<gazebo reference="base">
  <mu1>0.8</mu1><mu2>0.8</mu2>
  <kp>1e6</kp>
  <gravity>false</gravity>
  <selfCollide>true</selfCollide>
</gazebo>
<gazebo reference="tip"><kp value="3"/><selfCollide>false</selfCollide><mu1>1</mu1><mu2>2</mu2>
</gazebo>
<gazebo reference="mount"><stiffness>2</stiffness></gazebo>
<gazebo reference="nobody"><kp>1</kp></gazebo>
<gazebo><static>true</static><self_collide>true</self_collide></gazebo>"""

    assert warnings(tags) == (
        "<gazebo> (line 11) is left out: there is no link or joint 'nobody'",
        "<kp> of 'base' (line 4), 'tip' (line 8) has no effect: contacts are as stiff as steps of "
        "physics allow, and DART does not read it",
        "<mu2> of 'tip' (line 8) has no effect: without <fdir1> friction is <mu1> in all "
        "directions",
        "<stiffness> of 'mount' (line 10) is unknown (is it springStiffness?)",
    )


def test_a_plugin_of_the_whole_robot_that_is_not_served_is_told() -> None:
    tags = """
<gazebo><plugin name="drive" filename="libgazebo_ros_hover.so"><ros/></plugin></gazebo>
<gazebo reference="base"><plugin name="bump" filename="libbumper.so"/></gazebo>"""

    assert warnings(tags) == (
        "Plug-in 'drive' (libgazebo_ros_hover.so, line 2) is left out: it is not simulated",
        "Plug-in 'bump' (libbumper.so, line 3) is left out: it is not simulated",
    )


@pytest.mark.parametrize(
    "filename",
    [
        "libgazebo_ros2_control.so",
        "gz_ros2_control-system",
        "libgz_ros2_control-system.so",
        "ign_ros2_control-system",
        "gz-sim-sensors-system",
        "libignition-gazebo6-imu-system.so",
    ],
)
def test_a_plugin_that_stands_for_what_there_is_is_not_told(filename: str) -> None:
    assert warnings(f'<gazebo><plugin name="p" filename="{filename}"/></gazebo>') == ()


def test_of_a_plugin_that_is_a_controller_the_tags_are_told_that_it_does_not_have() -> None:
    plugin = (
        '<gazebo><plugin name="p" filename="libgazebo_ros_diff_drive.so"><left_joint>a</left_joint>'
        "\n<legacy_mode>true</legacy_mode></plugin></gazebo>"
    )
    assert warnings(plugin) == ("<legacy_mode> of plug-in 'p' (line 2) has no effect",)


def test_of_the_plugin_that_runs_controllers_the_tags_are_told_that_change_nothing() -> None:
    plugin = (
        '<gazebo><plugin name="p" filename="libgz_ros2_control-system.so">'
        "<parameters>a.yaml</parameters><hold_joints>{}</hold_joints>"
        "\n<position_proportional_gain>{}</position_proportional_gain></plugin></gazebo>"
    )
    assert warnings(plugin.format("true", "0")) == ()
    assert warnings(plugin.format("false", "0.1")) == (
        "<hold_joints> of plug-in 'p' (line 1) has no effect",
        "<position_proportional_gain> of plug-in 'p' (line 2) has no effect",
    )


def test_a_camera_without_its_tag_is_told() -> None:
    assert warnings('<gazebo reference="tip">\n<sensor name="eye" type="camera"/></gazebo>') == (
        "Sensor 'eye' on link 'tip' (line 2) is left out: it has no <camera>",
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            ("<horizontal_fov>1", "<horizontal_fov>4"),
            "a pinhole camera cannot have a field of view of 4 rad",
        ),
        (
            (IMAGE, f"{IMAGE}<clip><near>9</near><far>2</far></clip>"),
            "its clip range is empty: 9 m and 2 m",
        ),
    ],
)
def test_a_camera_that_cannot_see_is_told(change: tuple[str, str], words: str) -> None:
    built = model(link("base", ""), link("tip", ""), MOUNT, camera().replace(*change))
    assert built.cameras == ()
    assert words in built.warnings[0]


@pytest.mark.parametrize("reference", ["mount", "nobody"])
def test_a_camera_on_what_is_no_link_is_left_out_and_told(reference: str) -> None:
    tags = camera().replace('reference="tip"', f'reference="{reference}"')
    built = model(link("base", ""), link("tip", ""), MOUNT, tags)

    assert built.cameras == ()
    assert len(built.warnings) == 1 and "is left out: there is no" in built.warnings[0]


@pytest.mark.parametrize(
    ("inside", "beside", "tag"),
    [
        ("<distortion><center>0.4 0.5</center></distortion>", "", "center"),
        ("<lens><type>equidistant</type><scale_to_hfov>true</scale_to_hfov></lens>", "", "type"),
        ("<pose>0 0 1 0 0 0</pose>", "", "pose"),
        ("", "<parent>base</parent>", "parent"),
    ],
)
def test_what_a_camera_does_not_do_is_told(inside: str, beside: str, tag: str) -> None:
    line = 3 if inside else 4
    assert warnings(camera(inside, beside)) == (
        f"<{tag}> of sensor 'eye' (line {line}) has no effect",
    )


def test_a_depth_cameras_format_of_depths_is_not_told() -> None:
    depth = camera("<image><format>R_FLOAT32</format></image>").replace(
        '"camera"', '"depth_camera"'
    )
    assert "format" not in "".join(warnings(depth))


def test_what_no_camera_has_and_what_stands_there_twice_is_told() -> None:
    again = camera("<image><format>L16</format></image>", "<update_rat>3</update_rat>")
    assert warnings(again) == (
        "<image> of sensor 'eye' (line 3) is given again: the first is used",
        "<update_rat> of sensor 'eye' (line 4) is unknown (is it update_rate?)",
    )


def test_what_a_sensors_plugin_does_not_do_is_told() -> None:
    plugin = """<plugin name="p" filename="libgazebo_ros_camera.so"><ros>
      <namespace>/front</namespace>
      <remapping>~/image_raw:=/image_raw</remapping><remapping>~/camera_info:=info</remapping>
      <qos><topic name="a"/></qos></ros><min_depth>0.4</min_depth><autoDistortion>1</autoDistortion>
      <distortionK1>0.0</distortionK1></plugin>"""

    assert warnings(camera("", plugin)) == (
        "<qos> of plug-in 'p' (line 7) has no effect",
        "<autoDistortion> of plug-in 'p' (line 7) has no effect",
    )


def test_what_an_imu_does_not_do_is_told() -> None:
    axis = "<x>\n<noise><stddev>0.1</stddev></noise></x><y><noise><stddev>0.0</stddev></noise></y>"
    tags = f"""<gazebo reference="tip"><sensor name="i" type="imu"><topic>imu</topic>
<imu><angular_velocity>{axis}</angular_velocity>
<orientation_reference_frame><localization>GRAV_UP</localization></orientation_reference_frame></imu>
<lens/></sensor></gazebo>"""

    assert warnings(tags) == (
        "<localization> of sensor 'i' (line 4) has no effect",
        "<lens> of sensor 'i' (line 5) is unknown",
    )


def test_what_changes_nothing_is_not_told() -> None:
    tags = """
<gazebo reference="base"><material>Gazebo/Red</material><fdir1>1 0 0</fdir1>
  <visual><material><ambient>1 0 0 1</ambient></material></visual>
  <gravity>1</gravity><turnGravityOff>false</turnGravityOff><laserRetro>0.0</laserRetro></gazebo>
<gazebo reference="mount"><preserveFixedJoint>true</preserveFixedJoint>
  <provideFeedback>true</provideFeedback></gazebo>
<gazebo reference="tip"><sensor name="i" type="imu"><always_on>1</always_on>
  <imu><enable_orientation>true</enable_orientation></imu>
  <plugin name="p" filename="libgazebo_ros_imu_sensor.so"><ros>
    <remapping>~/out:=imu/data</remapping></ros><topicName>imu/data</topicName>
    <bodyName>tip</bodyName><gaussianNoise>0.0</gaussianNoise><rpyOffset>0 0 0</rpyOffset>
    <initialOrientationAsReference>false</initialOrientationAsReference></plugin></sensor></gazebo>
<gazebo/>"""

    assert warnings(tags) == ()
    assert warnings(camera("<noise><type>none</type></noise>", "<visualize>true</visualize>")) == ()


def test_a_sensor_of_another_kind_is_told_by_who_makes_sensors() -> None:
    scan = "<ray><noise><stddev>1</stddev></noise></ray>"
    tags = f'<gazebo reference="tip"><sensor name="l" type="echo">{scan}</sensor></gazebo>'

    assert warnings(tags) == ()


def test_what_a_lidar_does_not_do_is_told() -> None:
    inside = "<range><min>0.1</min><max>9</max><resolution>0.01</resolution></range>"
    inside += "<noise><stddev>0.1</stddev></noise>\n<visibility_mask>3</visibility_mask>"
    plugin = """<plugin name="p" filename="libgazebo_ros_ray_sensor.so">
      <ros><namespace>a</namespace><remapping>~/out:=scan</remapping></ros>
      <output_type>sensor_msgs/LaserScan</output_type><min_intensity>9</min_intensity></plugin>"""
    tags = f"""<gazebo reference="tip"><sensor name="l" type="ray"><ray>{inside}</ray>
{plugin}</sensor></gazebo>"""

    assert warnings(tags) == (
        "<visibility_mask> of sensor 'l' (line 2) has no effect",
        "<min_intensity> of plug-in 'p' (line 5) has no effect",
    )


def test_the_arm_asks_for_nothing_that_it_does_not_get() -> None:
    assert build_model(RobotDescription.from_urdf(teleop_urdf())).warnings == ()


def test_the_frame_of_a_sensor_stands_in_any_of_gazebos_tags() -> None:
    for tag in ("gz_frame_id", "ignition_frame_id", "frame_id"):
        sensor = f'<sensor name="i" type="imu"><{tag}>there</{tag}></sensor>'
        parts = (link("tip", ""), f'<gazebo reference="tip">{sensor}</gazebo>')
        assert robot(*parts).gazebo.sensors[0].frame == "there"


def test_what_a_plugin_says_that_stands_for_what_there_is_is_told_by_the_check_alone() -> None:
    engine = "<render_engine>ogre2</render_engine>"
    tags = f'<gazebo><plugin name="p" filename="gz-sim-sensors-system">{engine}</plugin></gazebo>'
    urdf = robot(link("base", ""), tags).urdf
    assert unsupported_tags(urdf) == []
    assert gazebo_only_tags(urdf) == [
        "Without meaning outside of Gazebo's window, drawing and solver: <render_engine> (line 1)"
    ]


def test_what_the_ros_of_a_plugin_does_not_do_is_told() -> None:
    ros = "<ros><namespace>a</namespace><qos><topic name='x'/></qos></ros><gain>3</gain>"
    for filename in ("libgazebo_ros_diff_drive.so", "libgazebo_ros_ft_sensor.so"):
        plugin = f'<gazebo><plugin name="p" filename="{filename}">{ros}</plugin></gazebo>'
        assert unsupported_tags(robot(link("base", ""), plugin).urdf) == [
            "<gain> of plug-in 'p' (line 1) has no effect",
            "<qos> of plug-in 'p' (line 1) has no effect",
        ]


def test_of_the_plugin_that_runs_controllers_what_is_neither_namespace_nor_name_is_told() -> None:
    rules = "<remapping>~/odom:=odom</remapping>\n<qos>best_effort</qos>"
    plugin = f'<plugin name="p" filename="gz_ros2_control-system"><ros>{rules}</ros></plugin>'
    assert warnings(f"<gazebo>{plugin}</gazebo>") == (
        "<qos> of plug-in 'p' (line 2) has no effect",
    )


def test_bullets_resistance_to_rolling_beside_odes_friction_does_not_brake_wheels() -> None:
    bullet = "<bullet><rolling_friction>0.1</rolling_friction></bullet>"

    def wheel(ode: str) -> str:
        friction = f"<collision><surface><friction>{ode}\n{bullet}</friction></surface></collision>"
        return f'<gazebo reference="base">{friction}</gazebo>'

    beside = robot(link("base"), wheel("<ode><mu>0.3</mu><mu2>0.3</mu2></ode>"))
    assert beside.gazebo.links["base"].surface is None
    assert unsupported_tags(beside.urdf) == [
        "<rolling_friction> of 'base' (line 3) has no effect beside <ode>: of Gazebo's engines "
        "Bullet alone reads it"
    ]
    alone = robot(link("base"), wheel("")).gazebo.links["base"].surface
    assert alone is not None
    assert alone.rolling == 0.1
