"""Verbs of ``ros2`` and their flags: those of Jazzy, and those that Lyrical adds.

A slash separates the alternative names of a flag. `tests.ros2_table` compares these flags with the
declarations of teleopctl's verbs.
"""

from __future__ import annotations

_NODE = "--spin-time -s/--use-sim-time"
_GRAPH = f"{_NODE} --no-daemon"
_QOS = (
    "--qos-profile --qos-depth --qos-history --qos-reliability --qos-durability --qos-liveliness "
    "--qos-liveliness-lease-duration-seconds"
)
_TEXT = "--csv -f/--full-length -l/--truncate-length --no-arr --no-str --flow-style"
_PARAM = f"--include-hidden-nodes --timeout --service-timeout {_GRAPH}"
_CONTROL = f"-c/--controller-manager --include-hidden-nodes --ros-args {_GRAPH}"
_LIFECYCLE = f"--timeout {_GRAPH}"
_KINDS = "-m/--only-msgs -s/--only-srvs -a/--only-actions"
_COMPONENT = (
    "-n/--node-name --node-namespace --log-level -r/--remap-rule -p/--parameter "
    f"-e/--extra-argument {_LIFECYCLE}"
)
_DOCTOR = "-r/--report -rf/--report-failed -ep/--exclude-packages -iw/--include-warnings"
_HELLO = "-t/--topic -ep/--emit-period -pp/--print-period --ttl -1/--once"
_TRACE = "-p/--path -u/--ust -k/--kernel -c/--context -l/--list -a/--append-trace"

FLAGS = {
    "action list": f"-t/--show-types -c/--count-actions {_GRAPH}",
    "action info": f"-t/--show-types -c/--count {_GRAPH}",
    "action type": _GRAPH,
    "action find": f"-c/--count-actions {_GRAPH}",
    "action send_goal": f"-f/--feedback --stdin -t/--timeout {_NODE}",
    "action echo": f"-i/--interfaces {_TEXT} {_QOS} {_GRAPH}",
    "bag record": (
        "-a/--all --all-topics --all-services --all-actions --topics --services --actions "
        "--topic-types -e/--regex --exclude-regex --exclude-topics --exclude-topic-types "
        "--exclude-services --exclude-actions --include-unpublished-topics "
        "--include-hidden-topics --ignore-leaf-topics --no-discovery -p/--polling-interval "
        "-o/--output -s/--storage -f/--serialization-format --storage-config-file "
        "--storage-preset-profile --custom-data -b/--max-bag-size -d/--max-bag-duration "
        "--max-bag-files --max-cache-size --max-cache-duration --snapshot-mode "
        "--compression-mode --compression-format --compression-queue-size "
        "--compression-threads --compression-threads-priority --qos-profile-overrides-path "
        "--static-topics-path --repeat-transient-local --repeat-all-transient-local "
        "--stats_max_publishing_rate --start-paused --use-sim-time --node-name --log-level "
        "--disable-keyboard-controls"
    ),
    "bag play": (
        "-i/--input -s/--storage -r/--rate -l/--loop -d/--delay --start-offset "
        "--playback-duration --playback-until-sec --playback-until-nsec -p/--start-paused "
        "--topics --services --actions -e/--regex -x/--exclude-regex --exclude-topics "
        "--exclude-services --exclude-actions -m/--remap --clock --clock-topics "
        "--clock-topics-all --qos-profile-overrides-path --read-ahead-queue-size "
        "--wait-for-all-acked --disable-loan-message --publish-service-requests "
        "--send-actions-as-client --service-requests-source --message-order "
        "--progress-bar-update-rate --progress-bar-separation-lines --storage-config-file "
        "--disable-keyboard-controls --log-level"
    ),
    "bag burst": (
        "-n/--num-messages --topics --services --actions --start-offset -m/--remap "
        "--qos-profile-overrides-path --read-ahead-queue-size --storage-config-file -s/--storage"
    ),
    "bag info": "-t/--topic-name -v/--verbose --sort -s/--storage",
    "bag convert": "-i/--input -o/--output-options --input-options",
    "bag reindex": "-s/--storage",
    "bag list": "-v/--verbose",
    "component types": "",
    "component list": f"--containers-only {_LIFECYCLE}",
    "component load": f"-q/--quiet {_COMPONENT}",
    "component unload": f"-q/--quiet {_LIFECYCLE}",
    "component standalone": f"-c/--container-node-name {_COMPONENT}",
    "control list_controllers": (
        "--claimed-interfaces --required-state-interfaces --required-command-interfaces "
        "--chained-interfaces --reference-interfaces --exported-interfaces -v/--verbose "
        f"{_CONTROL}"
    ),
    "control list_controller_types": _CONTROL,
    "control list_hardware_components": f"-v/--verbose {_CONTROL}",
    "control list_hardware_interfaces": f"-v/--verbose {_CONTROL}",
    "control load_controller": f"--set-state {_CONTROL}",
    "control unload_controller": _CONTROL,
    "control cleanup_controller": _CONTROL,
    "control set_controller_state": _CONTROL,
    "control switch_controllers": (
        "--activate --deactivate --strict --best-effort --activate-asap --switch-timeout "
        f"{_CONTROL}"
    ),
    "control set_hardware_component_state": _CONTROL,
    "control reload_controller_libraries": f"--force-kill {_CONTROL}",
    "control view_controller_chains": _CONTROL,
    "control view_hardware_status": f"-i/--hardware-id -d/--device-id {_NODE}",
    "daemon start": "-d/--debug",
    "daemon stop": "",
    "daemon status": "",
    "doctor": _DOCTOR,
    "doctor hello": _HELLO,
    "trace": f"-s/--session-name {_TRACE}",
    **{f"trace {verb}": "" for verb in ("pause", "resume", "stop")},
    "trace start": _TRACE,
    "wtf": _DOCTOR,
    "wtf hello": _HELLO,
    "extension_points": "-a/--all -v/--verbose",
    "extensions": "-a/--all -v/--verbose",
    "interface list": _KINDS,
    "interface package": _KINDS,
    "interface packages": _KINDS,
    "interface proto": "--no-quotes",
    "interface show": "--all-comments --no-comments",
    "launch": (
        "-n/--noninteractive -d/--debug -p/--print/--print-description "
        "-s/--show-args/--show-arguments -a/--show-all-subprocesses-output --launch-prefix "
        "--launch-prefix-filter -f/--log-file-name"
    ),
    "lifecycle nodes": f"-a/--all -c/--count-nodes {_LIFECYCLE}",
    "lifecycle get": f"--include-hidden-nodes {_LIFECYCLE}",
    "lifecycle list": f"--include-hidden-nodes -a/--all {_LIFECYCLE}",
    "lifecycle set": f"--include-hidden-nodes {_LIFECYCLE}",
    "multicast receive": "--group --port",
    "multicast send": "--group --port --ttl",
    "node list": f"-a/--all -c/--count-nodes {_GRAPH}",
    "node info": f"--include-hidden {_GRAPH}",
    "param list": (
        f"--filter --param-prefixes --param-type --include-hidden-nodes --service-timeout {_GRAPH}"
    ),
    "param get": f"--hide-type {_PARAM}",
    "param set": f"--atomic {_PARAM}",
    "param describe": _PARAM,
    "param dump": _PARAM,
    "param load": f"--no-use-wildcard {_PARAM}",
    "param delete": _PARAM,
    "pkg list": "",
    "pkg executables": "--full-path",
    "pkg prefix": "--share",
    "pkg xml": "-t/--tag",
    "pkg create": (
        "--build-type --dependencies --description --license --destination-directory "
        "--package-format/--package_format --maintainer-name --maintainer-email --node-name "
        "--library-name"
    ),
    "plugin list": "--packages --package",
    "run": "--prefix",
    "run tf2_ros static_transform_publisher": (
        "--frame-id --child-frame-id --x --y --z --roll --pitch --yaw --qx --qy --qz --qw"
    ),
    "run tf2_ros tf2_echo": "-r -t -p",
    "run tf2_ros tf2_monitor": "",
    "run tf2_tools view_frames": "-t/--wait-time -o/--output",
    "security create_keystore": "",
    "security create_enclave": "",
    "security list_enclaves": "",
    "security create_permission": "",
    "security generate_policy": _GRAPH,
    "security generate_artifacts": "-k/--keystore-root-path -e/--enclaves -p/--policy-files",
    "security create_key": "",
    "security list_keys": "",
    "service list": f"-t/--show-types -c/--count-services --include-hidden-services {_GRAPH}",
    "service type": "--include-hidden-services",
    "service find": "-c/--count-services --include-hidden-services",
    "service info": f"-v/--verbose {_GRAPH}",
    "service call": f"-r/--rate --stdin --timeout {_QOS}",
    "service echo": f"{_TEXT} {_QOS} {_GRAPH}",
    "test": (
        "-v/--verbose -s/--show-args/--show-arguments --package-name --junit-xml "
        "--disable-isolation"
    ),
    "topic list": (
        "-t/--show-types -c/--count-topics -v/--verbose --include-hidden-topics " + _GRAPH
    ),
    "topic info": f"-v/--verbose {_GRAPH}",
    "topic type": _GRAPH,
    "topic find": f"-c/--count-topics --include-hidden-topics {_GRAPH}",
    "topic echo": (
        "--once --timeout --field --filter --raw -i/--include-message-info --no-lost-messages "
        f"-c/--clear -n/--node-name {_TEXT} {_QOS} {_GRAPH}"
    ),
    "topic pub": (
        "-r/--rate -p/--print -1/--once -t/--times -w/--wait-matching-subscriptions "
        "--max-wait-time-secs --keep-alive -n/--node-name --stdin --yaml-file "
        f"{_QOS} {_NODE}"
    ),
    "topic hz": f"-w/--window --filter --wall-time -a/--all {_QOS} {_NODE}",
    "topic bw": f"-w/--window -a/--all {_QOS} {_NODE}",
    "topic delay": f"-w/--window {_QOS} {_NODE}",
}
"""Flags of ros2, by verb."""

ELSEWHERE = {
    "doctor": "doctor check",
    "run tf2_ros static_transform_publisher": "tf static",
    "run tf2_ros tf2_echo": "tf echo",
    "run tf2_ros tf2_monitor": "tf monitor",
    "run tf2_tools view_frames": "tf view_frames",
    "wtf": "wtf check",
}
"""teleopctl's names of verbs and programs, by their ROS 2 name, which is accepted too."""

NOT_HERE = {
    "security": (
        "keystores and enclaves are those of DDS; Zenoh's TLS and access control are set up "
        "[by its configuration](ros2.md#across-machines)"
    ),
    "launch -d": "means `--detach` here; use `--debug`",
    "trace": (
        "LTTng traces the C code of rclcpp and rcl, which is not here; `topic hz` and `topic "
        "delay` measure messages, and `control list_hardware_components -v` the control loop"
    ),
}
"""Reasons why a group of verbs or a flag is missing in teleopctl."""

OTHERWISE = {
    "action send_goal": "status 1 if the goal did not succeed",
    "bag record": "each file begins with the last messages of latched topics",
    "param describe": "status 1 if a parameter is not declared",
    "bag": "see [Record and play](bag.md)",
    "component": "components in Python; C++ is not loaded ([how](components.md))",
    "control view_controller_chains": "writes an SVG, a `.gv`, and a PDF if Graphviz is installed",
    "daemon": "a Zenoh router; it has no cache",
    "doctor": "[other checks](doctor.md); exit status with `--exit-status`",
    "extensions": "plug-ins of teleopctl's kinds ([which](extending/index.md))",
    "extension_points": "kinds of plug-ins ([which](extending/index.md))",
    "interface show": "definitions that come with teleopctl have no comments",
    "launch": "errors are reported with their line before the start ([more](launch_files.md))",
    "lifecycle set": "status 1 if the transition failed",
    "param delete": "status 1 if it is refused",
    "param dump": "patterns (`'/arm/*'`); `load` accepts its output",
    "param get": "several names and patterns (`'/arm/*'`)",
    "param load": "status 1 if it is refused",
    "param set": "several pairs, patterns (`'/arm/*'`); status 1 if it is refused",
    "plugin list": "the same as `extensions`, by distribution",
    "run": "the package is optional; takes a file by its path",
    "run tf2_ros static_transform_publisher": "the same as `tf static`",
    "run tf2_ros tf2_echo": "the same as `tf echo`",
    "run tf2_ros tf2_monitor": "the same as `tf monitor`; prints which node publishes a frame",
    "run tf2_tools view_frames": (
        "the same as `tf view_frames`; writes an SVG, a `.gv`, and a PDF if Graphviz is installed; "
        "status 1 if there are no transforms"
    ),
    "topic echo": (
        "several topics and patterns (`'/arm/*'`); `--field` may be repeated, `ranges[:10]`; QoS "
        "policies without a flag are matched to the publishers"
    ),
    "topic hz": "several topics and patterns (`'/arm/*'`)",
    "topic bw": "several topics and patterns (`'/arm/*'`)",
    "topic delay": "several topics and patterns (`'/arm/*'`)",
    "service type": "reports an unknown service",
    "topic pub": "`--once` waits for a subscription and reports it; `--stdin` takes several",
    "topic type": "reports an unknown topic",
}
"""Differences of a verb, or of all verbs of a group, other than flags."""

OTHER_TEXTS = [
    (
        "every verb",
        "an error is a line of its own for each verb, or a traceback",
        "`teleopctl: …` with ROS 2's words, and what to do below it",
        "an error names the next step, such as a similar name",
    ),
    (
        "every verb",
        "progress and warnings (`Waiting for …`) are partly on stdout",
        "all on stderr",
        "stdout has only what a script reads",
    ),
    (
        "topic pub",
        "a value that does not fit: Python's error",
        "`Failed to populate field: linear.x: expected float64, got 'fast'`",
        "the field, its type and the value are named; nothing is truncated",
    ),
    (
        "topic pub",
        "waits for a subscription without further words",
        "says at once that the topic has another type, and after a second what else it waits for",
        "a misspelt name or type is found at once",
    ),
    (
        "topic echo",
        "nothing if the topic has another type than the given one",
        "`WARNING: topic [/x] has the type …: only messages of the type … are received`",
        "it waits for a publisher of that type, as in ROS 2",
    ),
    (
        "topic echo",
        "with `--csv` no comma behind empty columns at the start of a line",
        "a comma between any two columns",
        "columns keep their positions",
    ),
    (
        "service call",
        "waits for ever if the service has another type",
        "an error with the type that the service has",
        "the wait would never end",
    ),
    (
        "topic type",
        "nothing for an unknown topic, as `service type` does",
        "`Unknown topic '/nope'`",
        "the status is ROS 2's, 1; the reason is added",
    ),
    (
        "interface show",
        "comments of the definitions",
        "none in definitions that come with teleopctl; those of your packages",
        "facts are taken over, texts of others are not",
    ),
    (
        "pkg list",
        "the packages of the installation",
        "those of teleopctl and yours, in the same form",
        "other packages are there; so too `pkg executables`, `interface list`, `extensions`",
    ),
    (
        "daemon status",
        "one line",
        "the same line, and the router's address on stderr",
        "the daemon is the router, whose address other programs need",
    ),
    (
        "doctor",
        "checks of DDS and of the installation",
        "[other checks](doctor.md), in the same frame",
        "neither is here",
    ),
    (
        "launch",
        "all output of all processes",
        "the same; of teleopctl's own launch files a terminal gets what is up, warnings and errors",
        "the rest, a hundred lines, is in the log, and on the terminal with `--verbose`",
    ),
    (
        "run",
        "`[ros2run]: …` after a program that failed",
        "nothing",
        "the program takes the place of the command",
    ),
]
"""Deviations from ROS 2's printed text: verb, ROS 2's text, teleopctl's text, and the reason."""
