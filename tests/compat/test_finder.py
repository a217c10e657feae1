"""Message packages that are not installed, each case in a process of its own."""

import pytest

from tests.compat.activated import output, run
from tests.samples import sample


def test_every_way_of_importing_a_message_gives_the_same_class():
    assert output(
        "import std_msgs\n"
        "alone = std_msgs.msg.String\n"
        "assert not hasattr(std_msgs, 'srv')\n"
        "import std_msgs.msg\n"
        "import std_msgs.msg as m\n"
        "from std_msgs.msg import String\n"
        "from std_msgs.msg._string import String as Direct\n"
        "from teleopctl.interfaces.store import get_message\n"
        "print(alone is std_msgs.msg.String is m.String is String is Direct"
        " is get_message('std_msgs/msg/String'))\n"
        "print(String(data='x'))"
    ).splitlines() == ["True", "std_msgs.msg.String(data='x')"]


def test_all_names_of_a_package_can_be_imported():
    assert output(
        "from geometry_msgs.msg import *\n"
        "print(Twist().linear.x, PoseStamped.TYPE_NAME, 'Quaternion' in dir())"
    ) == ("0.0 geometry_msgs/msg/PoseStamped True")


def test_services_and_actions_can_be_imported():
    assert output(
        "from example_interfaces.srv import AddTwoInts\n"
        "from example_interfaces.action import Fibonacci\n"
        "print(AddTwoInts.Request(a=1, b=2), Fibonacci.Goal(order=5).order)"
    ) == ("example_interfaces.srv.AddTwoInts_Request(a=1, b=2) 5")


def test_classes_can_be_pickled():
    assert (
        output(
            "import pickle\n"
            "from std_msgs.msg import String\n"
            "from std_srvs.srv import Trigger\n"
            "for c in (String, Trigger, Trigger.Request):\n"
            "    assert pickle.loads(pickle.dumps(c)) is c"
        )
        == ""
    )


@pytest.mark.parametrize(
    ("code", "error"),
    sample(
        [
            ("from std_msgs.msg import Strin", "did you mean String?"),
            ("import foo_msgs.msg", "ModuleNotFoundError: No module named 'foo_msgs'"),
            ("import std_msgs.srv", "ModuleNotFoundError: No module named 'std_msgs.srv'"),
            ("import std_msgs.msg.foo", "ModuleNotFoundError: No module named 'std_msgs.msg.foo'"),
            ("from std_srvs.srv import Triger", "did you mean Trigger?"),
            ("import std_msgs.foo", "ModuleNotFoundError: No module named 'std_msgs.foo'"),
            ("import rclpy.foo", "ModuleNotFoundError: No module named 'rclpy.foo'"),
            ("import std_msgs.msg\nstd_msgs.msg.foo", "AttributeError"),
        ],
        2,
    ),
)
def test_what_does_not_exist_is_an_ordinary_import_error(code, error):
    done = run(code)
    assert done.returncode == 1
    assert error in done.stderr.splitlines()[-1]


def test_only_message_packages_come_from_a_finder():
    code = """
import rclpy, std_msgs.msg, tf2_ros
for module in (rclpy, tf2_ros, std_msgs, std_msgs.msg):
    print(type(module.__spec__.loader).__module__)
"""
    python, ours = "_frozen_importlib_external", "teleopctl.compat.finder"
    assert output(code).split() == [python, python, ours, ours]


def test_what_is_really_installed_wins(tmp_path):
    package = tmp_path / "std_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "msg" / "__init__.py").write_text("String = 'the real one'\n")
    code = "from std_msgs.msg import String\nfrom std_srvs.srv import Empty\nprint(String, Empty)"
    assert output(code, tmp_path) == "the real one <class 'std_srvs.srv._empty.Empty'>"


def test_the_folder_of_a_source_package_does_not_hide_its_module(tmp_path):
    """Tests are run from the folder with the packages, as ``pytest my_package/test``."""
    package = tmp_path / "arm_tools"
    (package / "arm_tools").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arm_tools</name></package>")
    (package / "arm_tools" / "__init__.py").write_text("SIZE = 3\n")
    (tmp_path / "other_folder").mkdir()
    assert output(
        "import arm_tools, other_folder\nprint(arm_tools.SIZE, other_folder.__file__)",
        tmp_path,
        TELEOPCTL_PACKAGE_PATH=str(tmp_path),
    ) == ("3 None")


def test_a_source_package_does_not_hide_its_own_interfaces(tmp_path):
    package = tmp_path / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>gadget_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text("string label\n")
    assert output(
        "from gadget_msgs.msg import Gadget\nprint(Gadget(label='a'))",
        tmp_path,
        TELEOPCTL_PACKAGE_PATH=str(tmp_path),
    ) == ("gadget_msgs.msg.Gadget(label='a')")


def test_a_package_of_the_user_adds_to_one_that_is_known(tmp_path):
    package = tmp_path / "std_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "srv").mkdir()
    (package / "package.xml").write_text("<package><name>std_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text("string label\n")
    (package / "srv" / "Turn.srv").write_text("float64 angle\n---\n")
    assert output(
        "from std_msgs.msg import Gadget, String\nfrom std_msgs.srv import Turn\n"
        "print(Gadget(label='a'), String(data='b'), Turn.Request(angle=1.0).angle)",
        tmp_path,
        TELEOPCTL_PACKAGE_PATH=str(tmp_path),
    ) == ("std_msgs.msg.Gadget(label='a') std_msgs.msg.String(data='b') 1.0")


def test_other_imports_are_left_alone():
    code = "import json, xml.dom.minidom\ntry: import org.python\nexcept ImportError: print('no')"
    assert output(code) == "no"
    # What Python's own modules try is none of ours: packages are not looked for.
    code = "import sys, copy, mimetypes\nprint('teleopctl.packages.source_folders' in sys.modules)"
    assert output(code) == "False"


def test_a_distribution_that_is_not_known_is_named_where_messages_are_wanted():
    done = run("import std_msgs.msg", ROS_DISTRO="noetic")
    assert "No module named 'std_msgs': ROS_DISTRO is 'noetic'" in done.stderr.splitlines()[-1]
    code = "from importlib.util import find_spec\nprint(find_spec('not_there'))"
    assert output(code, ROS_DISTRO="noetic") == "None"


def test_asking_for_a_missing_attribute_is_an_ordinary_question():
    assert output("import std_msgs.msg\nprint(hasattr(std_msgs.msg, 'Strin'))") == "False"


def test_modules_list_their_classes():
    assert output("import std_srvs.srv\nprint(dir(std_srvs.srv))") == (
        "['Empty', 'SetBool', 'Trigger']"
    )
    assert "SetBool_Request" in output("import std_srvs.srv._set_bool as m\nprint(dir(m))")
