"""``teleopctl interface list|package|packages|show|proto``."""

import json

import pytest

GADGET = """\
# What a gadget says.
std_msgs/Header header  # when

Force force # at the tip
string<=10[<=3] names ["a#b", 'c'] # of its parts
uint8 STOPPED=0
"""
FORCE = "# Newton\nfloat64 newton # along x\n"


@pytest.fixture(scope="module")
def ros(shared_ros):
    """With a package of one's own, whose definitions have comments."""
    package = shared_ros.folder / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>gadget_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text(GADGET)
    (package / "msg" / "Force.msg").write_text(FORCE)
    return shared_ros


def printed(ros, command: str) -> str:
    done = ros.run(f"interface {command}")
    assert (done.returncode, done.stderr) == (0, "")
    text: str = done.stdout
    return text


def refused(ros, command: str) -> tuple[int, str]:
    done = ros.run(f"interface {command}")
    assert done.stdout == ""
    return done.returncode, done.stderr.splitlines()[0]


def test_a_definition_is_shown_with_those_of_its_messages_below_their_fields(ros):
    assert printed(ros, "show geometry_msgs/msg/Vector3Stamped") == (
        "std_msgs/Header header\n"
        "\tbuiltin_interfaces/Time stamp\n"
        "\t\tint32 sec\n"
        "\t\tuint32 nanosec\n"
        "\tstring frame_id\n"
        "Vector3 vector\n"
        "\tfloat64 x\n"
        "\tfloat64 y\n"
        "\tfloat64 z\n"
    )


def test_the_sections_of_a_service_are_parted_as_in_its_file(ros):
    text = "bool data\n---\nbool success\nstring message\n"
    assert printed(ros, "show std_srvs/srv/SetBool") == text


def test_its_own_comments_are_shown_and_those_of_its_messages_are_not(ros):
    shown = printed(ros, "show gadget_msgs/msg/Gadget")
    assert shown.startswith("# What a gadget says.\nstd_msgs/Header header  # when\n\tbuiltin")
    assert "\n\nForce force # at the tip\n\tfloat64 newton\nstring<=10" in shown


def test_all_comments_are_shown_on_request(ros):
    shown = printed(ros, "show --all-comments gadget_msgs/msg/Gadget")
    assert "Force force # at the tip\n\t# Newton\n\tfloat64 newton # along x\n" in shown


def test_without_comments_only_fields_and_constants_are_left(ros):
    shown = printed(ros, "show --no-comments gadget_msgs/msg/Gadget").splitlines()
    assert shown[0] == "std_msgs/Header header"
    assert shown[-4:] == [
        "Force force",
        "\tfloat64 newton",
        """string<=10[<=3] names ["a#b", 'c']""",
        "uint8 STOPPED=0",
    ]


def test_the_name_may_come_from_a_pipe(ros):
    done = ros.run("interface show -", input="std_msgs/msg/Bool\n")
    assert (done.returncode, done.stdout) == (0, "bool data\n")


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        ("std_msgs/Bool", 1, "Invalid name 'std_msgs/Bool'. Expected three parts separated by '/'"),
        ("nobodys/msg/Bool", 1, "Unknown package 'nobodys'"),
        ("std_msgs/msg/Bol", 1, "Could not find the interface 'std_msgs/msg/Bol'"),
        ("--all-comments --no-comments std_msgs/msg/Bool", 2, "--all-comments and --no-comments"),
    ],
)
def test_what_cannot_be_shown_is_told(ros, words, status, text):
    code, line = refused(ros, f"show {words}")
    assert code == status
    assert text in line


def test_a_prototype_is_the_yaml_of_what_is_sent(ros):
    assert printed(ros, "proto geometry_msgs/msg/Point") == '"x: 0.0\ny: 0.0\nz: 0.0\n"\n'
    assert printed(ros, "proto --no-quotes std_srvs/srv/SetBool") == "data: false\n\n"
    assert printed(ros, "proto --no-quotes example_interfaces/action/Fibonacci") == "order: 0\n\n"
    assert json.loads(printed(ros, "proto --json std_srvs/srv/SetBool")) == {"data": False}


def test_types_are_listed_by_kind(ros):
    text = printed(ros, "list")
    assert text.startswith("Messages:\n    ")
    assert "    action_msgs/msg/GoalInfo\n" in text.partition("\nServices:\n")[0]
    assert text.index("\nServices:\n    ") < text.index("\nActions:\n    ")
    assert "    gadget_msgs/msg/Gadget\n" in text
    assert printed(ros, "list --only-actions").splitlines()[0] == "Actions:"


def test_the_types_of_a_package_are_listed_without_titles(ros):
    found = "std_srvs/srv/Empty\nstd_srvs/srv/SetBool\nstd_srvs/srv/Trigger\n"
    assert printed(ros, "package std_srvs") == found
    assert printed(ros, "package std_srvs --only-msgs") == ""
    assert printed(ros, "package gadget_msgs").split() == [
        "gadget_msgs/msg/Force",
        "gadget_msgs/msg/Gadget",
    ]
    assert refused(ros, "package nobodys") == (1, "teleopctl: Unknown package 'nobodys'")


def test_the_packages_that_define_a_kind_are_listed(ros):
    assert "gadget_msgs" in printed(ros, "packages").split()
    actions = printed(ros, "packages --only-actions").split()
    assert "example_interfaces" in actions
    assert "gadget_msgs" not in actions
