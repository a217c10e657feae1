"""What verbs print, character for character as ros2 does, of one small graph."""

import re
from functools import partial

import pytest

from teleopctl.cli import main
from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.wire import Graph
from tests import ROOT
from tests.ros2_table import rows
from tests.system.ros2_refusals import REFUSALS
from tests.system.test_control_texts import TEXTS as CONTROL_TEXTS

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
TALKER = "demo_nodes_cpp demo_nodes_cpp::Talker"
GOAL = """\
Sending goal:
     order: 2

Goal accepted with ID: ID

Result:
    sequence:
- 0
- 1
- 1

Goal finished with status: SUCCEEDED
"""
CONFIGURE = "- configure [1]\n\tStart: unconfigured\n\tGoal: configuring\n"
SHUTDOWN = "- shutdown [5]\n\tStart: unconfigured\n\tGoal: shuttingdown\n"

STATE = "lifecycle_msgs/srv/GetState"
CALLED = """\
requester: making request: lifecycle_msgs.srv.GetState_Request()

response:
lifecycle_msgs.srv.GetState_Response(current_state=lifecycle_msgs.msg.State(id=1, \
label='unconfigured'))

"""

TOPICS = {
    "/lc_talker/transition_event": "lifecycle_msgs/msg/TransitionEvent",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    "/rosout": "rcl_interfaces/msg/Log",
}
OF_EACH_NODE = {
    "describe_parameters": "rcl_interfaces/srv/DescribeParameters",
    "get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
    "get_parameters": "rcl_interfaces/srv/GetParameters",
    "get_type_description": "type_description_interfaces/srv/GetTypeDescription",
    "list_parameters": "rcl_interfaces/srv/ListParameters",
    "set_parameters": "rcl_interfaces/srv/SetParameters",
    "set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
}
OF_LC_TALKER = {
    "change_state": "lifecycle_msgs/srv/ChangeState",
    "get_available_states": "lifecycle_msgs/srv/GetAvailableStates",
    "get_available_transitions": "lifecycle_msgs/srv/GetAvailableTransitions",
    "get_state": "lifecycle_msgs/srv/GetState",
    "get_transition_graph": "lifecycle_msgs/srv/GetAvailableTransitions",
}
SERVICES = {
    **{f"/ComponentManager/{name}": kind for name, kind in OF_EACH_NODE.items()},
    **{f"/fibonacci_action_server/{name}": kind for name, kind in OF_EACH_NODE.items()},
    **{f"/lc_talker/{name}": kind for name, kind in sorted((OF_EACH_NODE | OF_LC_TALKER).items())},
    **{f"/test/{name}": kind for name, kind in OF_EACH_NODE.items()},
}

# The transitions of every managed node, in the order in which rcl_lifecycle registers them.
TRANSITIONS = [
    ("configure", 1, "unconfigured", "configuring"),
    ("transition_success", 10, "configuring", "inactive"),
    ("transition_failure", 11, "configuring", "unconfigured"),
    ("transition_error", 12, "configuring", "errorprocessing"),
    ("cleanup", 2, "inactive", "cleaningup"),
    ("transition_success", 20, "cleaningup", "unconfigured"),
    ("transition_failure", 21, "cleaningup", "inactive"),
    ("transition_error", 22, "cleaningup", "errorprocessing"),
    ("activate", 3, "inactive", "activating"),
    ("transition_success", 30, "activating", "active"),
    ("transition_failure", 31, "activating", "inactive"),
    ("transition_error", 32, "activating", "errorprocessing"),
    ("deactivate", 4, "active", "deactivating"),
    ("transition_success", 40, "deactivating", "inactive"),
    ("transition_failure", 41, "deactivating", "active"),
    ("transition_error", 42, "deactivating", "errorprocessing"),
    ("shutdown", 5, "unconfigured", "shuttingdown"),
    ("shutdown", 6, "inactive", "shuttingdown"),
    ("shutdown", 7, "active", "shuttingdown"),
    ("transition_success", 50, "shuttingdown", "finalized"),
    ("transition_failure", 51, "shuttingdown", "finalized"),
    ("transition_error", 52, "shuttingdown", "errorprocessing"),
    ("transition_success", 60, "errorprocessing", "unconfigured"),
    ("transition_failure", 61, "errorprocessing", "finalized"),
    ("transition_error", 62, "errorprocessing", "finalized"),
]

TEXTS: list[tuple[str | list[str], str]] = [
    ("node list", "/ComponentManager\n/fibonacci_action_server\n/lc_talker\n/test\n"),
    ("node list -c", "4\n"),
    (
        "topic list -v",
        "Published topics:\n"
        " * /lc_talker/transition_event [lifecycle_msgs/msg/TransitionEvent] 1 publisher\n"
        " * /parameter_events [rcl_interfaces/msg/ParameterEvent] 4 publishers\n"
        " * /rosout [rcl_interfaces/msg/Log] 4 publishers\n"
        "\n"
        "Subscribed topics:\n"
        "\n",
    ),
    ("topic list -t", "".join(f"{name} [{kind}]\n" for name, kind in TOPICS.items())),
    ("topic list -c", f"{len(TOPICS)}\n"),
    ("service list", "".join(f"{name}\n" for name in SERVICES)),
    ("service list -t", "".join(f"{name} [{kind}]\n" for name, kind in SERVICES.items())),
    ("service list -c", f"{len(SERVICES)}\n"),
    ("service find -c lifecycle_msgs/srv/GetState", "1\n"),
    (
        "topic info /lc_talker/transition_event",
        "Type: lifecycle_msgs/msg/TransitionEvent\nPublisher count: 1\nSubscription count: 0\n",
    ),
    ("topic type /rosout", "rcl_interfaces/msg/Log\n"),
    ("topic find rcl_interfaces/msg/ParameterEvent", "/parameter_events\n"),
    ("service type /lc_talker/get_state", f"{STATE}\n"),
    (f"service find {STATE}", "/lc_talker/get_state\n"),
    (
        "service info /lc_talker/get_state",
        f"Type: {STATE}\nClients count: 0\nServices count: 1\n",
    ),
    (f"service call /lc_talker/get_state {STATE}", CALLED),
    ("param get /lc_talker use_sim_time", "Boolean value is: False\n"),
    ("param set /lc_talker use_sim_time no", "Set parameter successful\n"),
    (
        "param list /lc_talker --param-type",
        "  start_type_description_service (type: boolean)\n  use_sim_time (type: boolean)\n",
    ),
    ("action list", "/fibonacci\n"),
    ("action list -t", f"/fibonacci [{FIBONACCI}]\n"),
    ("action list -c", "1\n"),
    ("action type /fibonacci", f"{FIBONACCI}\n"),
    (f"action find {FIBONACCI}", "/fibonacci\n"),
    (f"action find -c {FIBONACCI}", "1\n"),
    (
        "action info -t /fibonacci",
        "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n"
        f"    /fibonacci_action_server [{FIBONACCI}]\n",
    ),
    (
        "action info -c /fibonacci",
        "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n",
    ),
    ("action info /nobodys", "Action: /nobodys\nAction clients: 0\nAction servers: 0\n"),
    (["action", "send_goal", "/fibonacci", FIBONACCI, "{order: 2}"], GOAL),
    ("lifecycle nodes", "/lc_talker\n"),
    ("lifecycle nodes -c", "1\n"),
    ("lifecycle get", "/lc_talker: unconfigured [1]\n"),
    ("lifecycle get /lc_talker", "unconfigured [1]\n"),
    ("lifecycle list /lc_talker", CONFIGURE + SHUTDOWN),
    (
        "lifecycle list -a /lc_talker",
        "".join(
            f"- {label} [{number}]\n\tStart: {start}\n\tGoal: {goal}\n"
            for label, number, start, goal in TRANSITIONS
        ),
    ),
    ("lifecycle set /lc_talker configure", "Transitioning successful\n"),
    ("lifecycle get lc_talker", "inactive [2]\n"),
    ("lifecycle set /lc_talker cleanup", "Transitioning successful\n"),
    ("component types demo_nodes_cpp", "demo_nodes_cpp::Listener\ndemo_nodes_cpp::Talker\n"),
    (
        f"component load /ComponentManager {TALKER}",
        "Loaded component 1 into '/ComponentManager' container node as '/talker'\n",
    ),
    (f"component load -q /ComponentManager {TALKER} -n other", "2  /other\n"),
    ("component list", "/ComponentManager\n  1  /talker\n  2  /other\n"),
    ("component list --containers-only", "/ComponentManager\n"),
    ("component list ComponentManager", "1  /talker\n2  /other\n"),
    (
        "component unload /ComponentManager 1",
        "Unloaded component 1 from '/ComponentManager' container node\n",
    ),
    ("component unload -q /ComponentManager 2", "2\n"),
    ("bag list storage", "mcap\nsqlite3\nrosbag_v2\n"),
    ("daemon start", "The daemon is already running\n"),
    ("daemon status", "The daemon is running\n"),
    (
        "interface package std_srvs",
        "std_srvs/srv/Empty\nstd_srvs/srv/SetBool\nstd_srvs/srv/Trigger\n",
    ),
    ("interface proto std_srvs/srv/SetBool", '"data: false\n"\n'),
    ("interface proto --no-quotes std_srvs/srv/SetBool", "data: false\n\n"),
    (
        "interface show example_interfaces/srv/Trigger",
        "---\nbool success\nstring message\n",
    ),
    ("pkg executables lifecycle_py", "lifecycle_py lifecycle_talker\n"),
]


QOS = """\
QoS profile:
  Reliability: RELIABLE
  History (Depth): KEEP_LAST (10)
  Durability: VOLATILE
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

"""
ONE_PUB = ["topic", "pub", "-1", "-w", "0", "/p"]
STRING_PUB = ["topic", "pub", "-w", "0", "/greeting", "std_msgs/msg/String"]
STATES = ["unknown", "unconfigured", "inactive", "active", "finalized"]
CHANGING = ["configuring", "cleaningup", "shuttingdown", "activating", "deactivating"]
ALL_STATES = [*enumerate(STATES), *enumerate([*CHANGING, "errorprocessing"], start=10)]


def published(*messages: tuple[int, str]) -> str:
    """What ``topic pub`` prints: number and representation of each message."""
    lines = [f"publishing #{number}: {message}\n\n" for number, message in messages]
    return "".join(["publisher: beginning loop\n", *lines])


TWIST = """\
linear:
  x: 0.0
  y: 0.0
  z: 0.0
angular:
  x: 0.0
  y: 0.0
  z: 0.0
"""

TEXTS += [
    (
        "node info /lc_talker",
        "/lc_talker\n  Subscribers:\n\n  Publishers:\n"
        + "".join(f"    {name}: {kind}\n" for name, kind in TOPICS.items())
        + "  Service Servers:\n"
        + "".join(
            f"    {name}: {kind}\n" for name, kind in SERVICES.items() if "/lc_talker/" in name
        )
        + "  Service Clients:\n\n  Action Servers:\n\n  Action Clients:\n\n",
    ),
    ("node list --no-daemon -c", "4\n"),
    (
        "topic info --verbose /lc_talker/transition_event",
        "Type: lifecycle_msgs/msg/TransitionEvent\n\nPublisher count: 1\n\n"
        "Node name: lc_talker\nNode namespace: /\n"
        "Topic type: lifecycle_msgs/msg/TransitionEvent\n"
        "Topic type hash: "
        "RIHS01_d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38\n"
        f"Endpoint type: PUBLISHER\nGID: G\n{QOS}Subscription count: 0\n\n",
    ),
    (
        "service info --verbose /lc_talker/get_state",
        f"Type: {STATE}\n\nClients count: 0\n\nServices count: 1\n\n"
        f"Node name: lc_talker\nNode namespace: /\nService type: {STATE}\n"
        "Service type hash: "
        "RIHS01_800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795\n"
        f"Endpoint type: SERVER\nGID: G\n{QOS}",
    ),
    ("topic list --include-hidden-topics -c", f"{len(TOPICS) + 2}\n"),
    ("topic find -c rcl_interfaces/msg/Log", "1\n"),
    ("topic find std_msgs/msg/Empty", ""),
    ("topic find -c std_msgs/msg/Empty", "0\n"),
    ("service find std_srvs/srv/Empty", ""),
    ("service find lifecycle_msgs/srv/ChangeState", "/lc_talker/change_state\n"),
    (
        "service call /lc_talker/get_available_states lifecycle_msgs/srv/GetAvailableStates",
        "requester: making request: lifecycle_msgs.srv.GetAvailableStates_Request()\n\n"
        "response:\nlifecycle_msgs.srv.GetAvailableStates_Response(available_states=["
        + ", ".join(f"lifecycle_msgs.msg.State(id={i}, label='{n}')" for i, n in ALL_STATES)
        + "])\n\n",
    ),
    (
        [
            *["service", "call", "/lc_talker/get_parameters", "rcl_interfaces/srv/GetParameters"],
            "{names: [use_sim_time]}",
        ],
        "requester: making request: rcl_interfaces.srv.GetParameters_Request("
        "names=['use_sim_time'])\n\nresponse:\nrcl_interfaces.srv.GetParameters_Response("
        "values=[rcl_interfaces.msg.ParameterValue(type=1, bool_value=False, integer_value=0, "
        "double_value=0.0, string_value='', byte_array_value=[], bool_array_value=[], "
        "integer_array_value=[], double_array_value=[], string_array_value=[])])\n\n",
    ),
    ([*STRING_PUB, "--once", "{data: hi}"], published((1, "std_msgs.msg.String(data='hi')"))),
    ([*STRING_PUB, "-1", "data: 5"], published((1, "std_msgs.msg.String(data='5')"))),
    ([*STRING_PUB, "-1", "data: null"], published((1, "std_msgs.msg.String(data='None')"))),
    ([*STRING_PUB, "-1"], published((1, "std_msgs.msg.String(data='')"))),
    (
        [*STRING_PUB, *["-t", "3", "-r", "100", "-p", "2"], "data: hi"],
        published((2, "std_msgs.msg.String(data='hi')")),
    ),
    ([*STRING_PUB, *["-t", "1", "-p", "0"], "data: hi"], published()),
    (
        [*ONE_PUB, "geometry_msgs/msg/Twist", "{linear: {x: 1.5}}"],
        published(
            (
                1,
                "geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=1.5, y=0.0, z=0.0), "
                "angular=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.0))",
            )
        ),
    ),
    (
        [
            *["topic", "pub", "-1", "-w", "0", "/p", "std_msgs/msg/Int8MultiArray"],
            "{data: [-1, 2]}",
        ],
        published(
            (
                1,
                "std_msgs.msg.Int8MultiArray(layout=std_msgs.msg.MultiArrayLayout(dim=[], "
                "data_offset=0), data=[-1, 2])",
            )
        ),
    ),
    (
        [*ONE_PUB, "std_msgs/msg/ColorRGBA", "{r: 1, a: 0.5}"],
        published((1, "std_msgs.msg.ColorRGBA(r=1.0, g=0.0, b=0.0, a=0.5)")),
    ),
    ("param get --hide-type /lc_talker use_sim_time", "False\n"),
    ("param list /lc_talker", "  start_type_description_service\n  use_sim_time\n"),
    ("param list /lc_talker --filter use.*", "  use_sim_time\n"),
    (
        "param list /lc_talker --param-prefixes start_type_description_service",
        "  start_type_description_service\n",
    ),
    (
        "param describe /lc_talker use_sim_time",
        "Parameter name: use_sim_time\n  Type: boolean\n  Constraints:\n",
    ),
    (
        "param dump /lc_talker",
        "/lc_talker:\n  ros__parameters:\n    start_type_description_service: true\n"
        "    use_sim_time: false\n\n",
    ),
    (
        "param set --atomic /lc_talker use_sim_time false",
        "Set parameters atomically successful\n",
    ),
    (
        [*["action", "send_goal", "/fibonacci"], FIBONACCI, "{order: 0}"],
        GOAL.replace("order: 2", "order: 0").replace("- 0\n- 1\n- 1\n", "- 0\n- 1\n"),
    ),
    (
        "action info /fibonacci",
        "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n    /fibonacci_action_server\n",
    ),
    ("lifecycle nodes -a", "/lc_talker\n"),
    ("lifecycle set /lc_talker 1", "Transitioning successful\n"),
    ("lifecycle set /lc_talker activate", "Transitioning successful\n"),
    ("lifecycle get /lc_talker", "active [3]\n"),
    (
        "lifecycle list /lc_talker",
        "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
        "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n",
    ),
    ("lifecycle set lc_talker deactivate", "Transitioning successful\n"),
    ("component list", "/ComponentManager\n"),
    ("component list ComponentManager", ""),
    ("interface show std_srvs/srv/SetBool", "bool data\n---\nbool success\nstring message\n"),
    (
        "interface show example_interfaces/action/Fibonacci",
        "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n",
    ),
    (
        "interface show std_msgs/msg/Header",
        "builtin_interfaces/Time stamp\n\tint32 sec\n\tuint32 nanosec\nstring frame_id\n",
    ),
    (
        "interface show --no-comments geometry_msgs/msg/Twist",
        "".join(
            f"Vector3 {part}\n\tfloat64 x\n\tfloat64 y\n\tfloat64 z\n"
            for part in ("linear", "angular")
        ),
    ),
    ("interface show std_msgs/msg/Empty", ""),
    ("interface proto geometry_msgs/msg/Twist", f'"{TWIST}"\n'),
    ("interface proto --no-quotes geometry_msgs/msg/Twist", f"{TWIST}\n"),
    ("interface proto example_interfaces/action/Fibonacci", '"order: 0\n"\n'),
    (
        "interface package action_tutorials_interfaces",
        "action_tutorials_interfaces/action/Fibonacci\n",
    ),
    ("interface package std_msgs --only-srvs", ""),
    (
        "pkg executables action_tutorials_py",
        "".join(f"action_tutorials_py fibonacci_action_{role}\n" for role in ("client", "server")),
    ),
    ("pkg xml -t name lifecycle_py", "lifecycle_py\n"),
]


@pytest.fixture(scope="module")
def graph(shared_ros):
    for program in (
        "action_tutorials_py fibonacci_action_server",
        "lifecycle_py lifecycle_talker",
        "rclpy_components component_container",
    ):
        shared_ros.spawn(f"run {program}")
    shared_ros.wait_for_nodes("/fibonacci_action_server", "/lc_talker", "/ComponentManager")
    # A node stands in the graph before what it offers does.
    for line in (
        "action type /fibonacci",
        "topic type /lc_talker/transition_event",
        "lifecycle get /lc_talker",
        "lifecycle list /lc_talker",
        "param get /lc_talker use_sim_time",
        "component list /ComponentManager",
    ):
        eventually(partial(_succeeds, line), what=line)
    assert shared_ros.node.context.wait_for_graph(_is_whole, LONGEST_WAIT_S)
    return shared_ros


def _is_whole(graph: Graph) -> bool:
    return all(map(graph.servers, SERVICES)) and len(graph.publishers("/rosout")) == 4


def _succeeds(line: str) -> bool:
    return main.run(line.split()) == 0


# One test, since workers that shared it out would each start the graph.
def test_what_is_wrong_is_told_in_ros2s_words(graph, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # where there are no packages
    for refusal in REFUSALS:
        line = refusal.line
        capsys.readouterr()
        status = main.run(line if isinstance(line, list) else line.split())
        said = f"teleopctl: {refusal.words}{refusal.more}\n"
        assert (*capsys.readouterr(), status) == ("", said, refusal.status), line


def test_they_follow_one_another_as_in_a_terminal(graph, capsys):
    for line, text in TEXTS:
        capsys.readouterr()
        status = main.run(line if isinstance(line, list) else line.split())
        output, errors = capsys.readouterr()
        said = re.sub(r"\b[0-9a-f]{32}\b", "ID", output)
        said = re.sub(r"GID: [0-9a-f.]+", "GID: G", said)
        assert (said, status) == (text, 0), f"{line}\n{errors}"


# Where the texts of other verbs are compared, by their groups or, where they differ, by themselves.
ELSEWHERE = {
    "action": "system/test_action.py",
    "bag": "system/test_bag_record.py",
    "bag burst": "system/test_bag_play.py",
    "bag info": "cli/verbs/bag/test_info.py",
    "bag play": "system/test_bag_play.py",
    "bag reindex": "cli/verbs/bag/test_repair.py",
    "component": "system/test_components.py",
    "control": "system/test_control.py",
    "daemon": "system/test_daemon.py",
    "doctor": "system/test_doctor.py",
    "extension_points": "cli/test_strangers_verbs.py",
    "extensions": "cli/test_strangers_verbs.py",
    "interface": "cli/verbs/interface/test_show.py",
    "launch": "system/test_launch.py",
    "multicast": "system/test_doctor.py",
    "node": "system/test_node.py",
    "param": "system/test_param.py",
    "pkg": "cli/verbs/test_pkg.py",
    "pkg create": "cli/verbs/test_pkg_create.py",
    "plugin": "cli/test_strangers_verbs.py",
    "run": "system/test_run.py",
    "run tf2_ros": "system/test_tf.py",
    "run tf2_tools view_frames": "system/test_view_frames.py",
    "service": "system/test_service.py",
    "service list": "system/test_node.py",
    "test": "compat/launch_testing/test_launch_test.py",
    "topic": "system/test_topic.py",
}


def test_two_hundred_texts_are_compared():
    assert len(TEXTS) + len(REFUSALS) + len(CONTROL_TEXTS) >= 200


def test_every_verb_of_ros2_has_its_text_somewhere():
    here = {" ".join(line if isinstance(line, list) else line.split()) for line, _ in TEXTS}
    missing = []
    for verb in (row.name for row in rows() if row.is_here):
        verb = verb.replace("wtf", "doctor")  # the same under another name
        if any(line.startswith(f"{verb} ") or line == verb for line in here):
            continue
        words = verb.split()
        names = (" ".join(words[:count]) for count in range(len(words), 0, -1))
        file = next((ELSEWHERE[name] for name in names if name in ELSEWHERE), None)
        text = (ROOT / "tests" / file).read_text(encoding="utf-8") if file else ""
        if not re.search(rf"\b{words[-1]}\b", text):
            missing.append(verb)
    assert not missing
