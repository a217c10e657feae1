"""Error messages of verbs: the words of ros2, and teleopctl's additions.

The words are those of the format strings in the sources of ros2cli, ros2launch and ros2bag (Jazzy).
teleopctl prints them after ``teleopctl: ``. The cause may follow on the same line, and a hint on
the next line.
"""

from typing import NamedTuple

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
STRING = "std_msgs/msg/String"
NODES = "/ComponentManager, /fibonacci_action_server, /lc_talker, /test"

_UNKNOWN_PACKAGE = (
    "\n  Put the folder of the package that defines it, with its package.xml, on "
    "TELEOPCTL_PACKAGE_PATH."
)
_NOT_YAML = ": This is not YAML: did not find expected node content in line 2, column 1"


class Refusal(NamedTuple):
    """Command line and its error message on stderr; the command prints nothing on stdout.

    Attributes:
        line: Command line after ``teleopctl``.
        words: Error message of ros2.
        more: Text that teleopctl adds.
        status: Exit status; that of ros2, unless docs/ros2_verbs.md names the difference.
    """

    line: str | list[str]
    words: str
    more: str = ""
    status: int = 1


_NO_TOPIC_TYPE = "The passed message type is invalid"
_NO_NODE = f": '/nope'\n  There are {NODES}."
_NO_LIFE = ": '/nope'\n  There is /lc_talker."

TOPIC = [
    Refusal("topic info /nope", "Unknown topic '/nope'"),
    # ros2 prints nothing, with the same status.
    Refusal("topic type /nope", "Unknown topic '/nope'"),
    Refusal("topic echo /rosout --field .", "Invalid field value '.'"),
    Refusal(
        f"topic echo /x {STRING} --once --qos-reliability best",
        "",
        "Invalid value for '--qos-reliability': 'best' is not one of 'system_default', 'reliable', "
        "'best_effort', 'best_available'.\n  See `teleopctl topic echo --help`.",
        2,
    ),
    Refusal(
        "topic echo /rosout nope/msg/X",
        _NO_TOPIC_TYPE,
        f": Unknown interface type nope/msg/X{_UNKNOWN_PACKAGE}",
    ),
    Refusal(
        "topic pub /x std_msgs",
        _NO_TOPIC_TYPE,
        ": 'std_msgs' is not the name of an interface type\n  Write it as package/msg/Name, for "
        "example std_msgs/msg/String.",
    ),
    Refusal(
        f"topic pub /x {STRING} hello",
        "The passed value needs to be a dictionary in YAML format",
        ", got 'hello'",
    ),
    Refusal(
        ["topic", "pub", "/x", STRING, "{data: ["],
        "The passed value needs to be in YAML string or a dictionary",
        _NOT_YAML,
    ),
    Refusal(
        ["topic", "pub", "-1", "-w", "0", "/x", STRING, "{date: 1}"],
        "Failed to populate field: ",
        "unknown field 'date' of std_msgs/msg/String (fields: data)\n"
        "  std_msgs/msg/String has the fields data (string).",
    ),
    Refusal(
        f"topic pub --max-wait-time-secs 1 /x {STRING}",
        "--max-wait-time-secs option is only effective with --wait-matching-subscriptions, --once "
        "or --times",
    ),
    Refusal("topic hz --all /x", "Cannot specify both --all/-a and topic names", status=2),
    Refusal("topic hz -w 0 /rosout", "", "The window must have at least one message", 2),
]

NODE = [
    Refusal("node info /nope", "Unable to find node '/nope'"),
]

SERVICE = [
    Refusal("service info /nope", "Unknown service '/nope'"),
    # ros2 prints nothing, with the same status.
    Refusal("service type /nope", "Unknown service '/nope'"),
    Refusal("service echo /nope", "Cannot find type for '/nope'"),
    Refusal(
        "service call /nope nope/srv/X",
        "The passed service type is invalid",
        f": Unknown interface type nope/srv/X{_UNKNOWN_PACKAGE}",
    ),
    Refusal(f"service call /nope {STRING}", "The passed type is not a service", f": {STRING}"),
    Refusal("service call -r 0 /nope std_srvs/srv/Empty", "rate must be greater than zero"),
    Refusal(
        ["service", "call", "/lc_talker/change_state", "lifecycle_msgs/srv/ChangeState", "{a: 1}"],
        "Failed to populate field: ",
        "unknown field 'a' of lifecycle_msgs/srv/ChangeState_Request (fields: transition)\n"
        "  lifecycle_msgs/srv/ChangeState_Request has the fields transition "
        "(lifecycle_msgs/Transition).",
    ),
]

PARAM = [
    Refusal("param list /nope", "Node not found", _NO_NODE),
    Refusal("param get /nope x --timeout 0", "Node not found", _NO_NODE),
    Refusal("param set /nope x 1 --timeout 0", "Node not found", _NO_NODE),
    Refusal("param describe /nope x --timeout 0", "Node not found", _NO_NODE),
    Refusal("param dump /nope --timeout 0", "Node not found", _NO_NODE),
    Refusal("param delete /nope x --timeout 0", "Node not found", _NO_NODE),
    Refusal(
        "param get /lc_talker speed",
        "Parameter not set",
        "\n  `teleopctl param list /lc_talker` lists what there is.",
    ),
    # rclpy's reason names no parameter: Invalid access to undeclared parameter(s): [].
    Refusal(
        "param set /lc_talker speed 1",
        "Setting parameter failed: ",
        "Parameter speed was not declared",
    ),
    Refusal(
        "param delete /lc_talker speed",
        "Deleting parameter failed: ",
        "Parameter speed was not declared",
    ),
    Refusal(
        "param set /lc_talker use_sim_time 7",
        "Setting parameter failed: Wrong parameter type, expected 'Type.BOOL' got 'Type.INTEGER'",
    ),
]

ACTION = [
    # ros2 prints nothing, with the same status.
    Refusal("action type /nope", "Unknown action '/nope'"),
    Refusal(
        "action send_goal /fibonacci nope/action/X {}",
        "The passed action type is invalid",
        f": Unknown interface type nope/action/X{_UNKNOWN_PACKAGE}",
    ),
    Refusal(
        f"action send_goal /fibonacci {STRING} {{}}",
        "The passed action type is invalid",
        f": {STRING} is not an action",
    ),
    Refusal(
        ["action", "send_goal", "/fibonacci", FIBONACCI, "{ord: 3}"],
        "Failed to populate message fields: ",
        f"unknown field 'ord' of {FIBONACCI}_Goal (fields: order)\n"
        f"  {FIBONACCI}_Goal has the fields order (int32).",
    ),
]

INTERFACE = [
    Refusal(
        "interface show std_msgs/String",
        "Invalid name 'std_msgs/String'. Expected three parts separated by '/'",
    ),
    Refusal("interface show nope/msg/X", "Unknown package 'nope'"),
    # ros2 prints the path of a file here.
    Refusal("interface show std_msgs/msg/X", "Could not find the interface '", "std_msgs/msg/X'"),
    Refusal("interface package nope", "Unknown package 'nope'"),
    Refusal("interface proto nope/msg/X", "Unknown package 'nope'"),
]

LIFECYCLE = [
    Refusal("lifecycle get /nope", "Node not found", _NO_LIFE),
    Refusal("lifecycle list /nope", "Node not found", _NO_LIFE),
    Refusal("lifecycle set /nope configure", "Node not found", _NO_LIFE),
    Refusal(
        "lifecycle set /lc_talker fly",
        "Unknown transition requested, available ones are:\n- configure [1]\n- shutdown [5]",
    ),
]

COMPONENT = [
    Refusal("component types nope", "Unable to find package 'nope'"),
    Refusal(
        "component list /nope",
        "Unable to find container node '/nope'",
        "\n  There is /ComponentManager.",
    ),
    Refusal(
        "component load /nope demo_nodes_cpp demo_nodes_cpp::Talker",
        "Unable to find container node '/nope'",
        "\n  There is /ComponentManager.",
    ),
    Refusal(
        "component load /ComponentManager nope nope::X",
        "Failed to load component: Could not find requested resource in ament index",
        "\n  Packages with components: composition, demo_nodes_cpp, robot_state_publisher, "
        "tf2_ros, topic_tools.",
    ),
    Refusal(
        "component load /ComponentManager demo_nodes_cpp demo_nodes_cpp::Fly",
        "Failed to load component: Failed to find class with the requested plugin name.",
        "\n  Did you mean demo_nodes_cpp::Talker or demo_nodes_cpp::Listener?",
    ),
    Refusal(
        "component unload /ComponentManager 9",
        "Failed to unload component 9 from '/ComponentManager' container node\n"
        "    No node found with unique_id: 9",
        "\n  `teleopctl component list /ComponentManager` prints those that there are.",
    ),
]

_PLACES = (
    "\n  Packages are searched in $TELEOPCTL_PACKAGE_PATH, below and above the current folder, "
    "in $AMENT_PREFIX_PATH and among the installed distributions."
)

PACKAGES = [
    Refusal("pkg prefix nope_pkg", "Package not found", f": 'nope_pkg'{_PLACES}"),
    Refusal("pkg xml nope_pkg", "Package not found", f": 'nope_pkg'{_PLACES}"),
    Refusal("pkg executables nope_pkg", "Package 'nope_pkg' not found", _PLACES),
    Refusal("run nope_pkg x", "Package 'nope_pkg' not found", _PLACES),
    Refusal(
        "run teleop_py_pkg nope",
        "No executable found",
        "\n  Package 'teleop_py_pkg' has no executable 'nope'. It has simple_parameter, "
        "simple_publisher, simple_subscriber.",
    ),
    Refusal("launch nope_pkg x.launch.py", "Package 'nope_pkg' not found", _PLACES),
    Refusal(
        "launch demo_nodes_cpp talker_listener_launch.py a",
        "malformed launch argument 'a', expected format '<name>:=<value>'",
        status=2,
    ),
]

BAG = [
    Refusal("bag info nope", "Bag path 'nope' does not exist!"),
    Refusal("bag play nope", "Bag path 'nope' does not exist!"),
    Refusal("bag reindex nope", "Must specify a bag directory"),
    Refusal(
        "bag record",
        "Need to specify at least one option out of --all, --all-topics, --all-services, ",
        "--all-actions, --services, --actions, --topics, --topic-types, --static-topics-path or "
        "--regex",
    ),
    Refusal(
        "bag record --topics /x --exclude-topics /y",
        "--exclude-topics argument requires either --all, --all-topics, --topic-types or --regex",
    ),
    Refusal(
        "bag record --topics /x --exclude-regex y",
        "--exclude-regex argument requires either --all, --all-topics, --topic-types, "
        "--all-services",
        ", --all-actions or --regex",
    ),
    Refusal(
        "bag record -a --use-sim-time --no-discovery",
        "--use-sim-time and --no-discovery both set, but are incompatible settings. "
        "The /clock topic needs to be discovered to record with sim time.",
    ),
    Refusal(
        "bag record -a --compression-format zstd",
        "Invalid choice: Cannot specify compression format without a compression mode.",
    ),
]

REFUSALS = [
    *(*TOPIC, *NODE, *SERVICE, *PARAM, *ACTION, *INTERFACE, *LIFECYCLE, *COMPONENT),
    *(*PACKAGES, *BAG),
]
