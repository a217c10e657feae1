"""The verbs of ``ros2``, so that one that is missing here is not taken for a misspelt one."""

from __future__ import annotations

from collections.abc import Sequence

VERBS = {
    "action": "echo find info list send_goal type",
    "bag": "burst convert info list play record reindex",
    "component": "list load standalone types unload",
    "control": (
        "cleanup_controller list_controller_types list_controllers list_hardware_components "
        "list_hardware_interfaces load_controller reload_controller_libraries "
        "set_controller_state set_hardware_component_state switch_controllers unload_controller "
        "view_controller_chains view_hardware_status"
    ),
    "daemon": "start status stop",
    "doctor": "hello",
    "extension_points": "",
    "extensions": "",
    "interface": "list package packages proto show",
    "launch": "",
    "lifecycle": "get list nodes set",
    "multicast": "receive send",
    "node": "info list",
    "param": "delete describe dump get list load set",
    "pkg": "create executables list prefix xml",
    "plugin": "list",
    "run": "",
    "security": (
        "create_enclave create_key create_keystore create_permission generate_artifacts "
        "generate_policy list_enclaves list_keys"
    ),
    "service": "call echo find info list type",
    "test": "",
    # These two are programs of tf2_ros and tf2_tools there.
    "tf": "monitor view_frames",
    "topic": "bw delay echo find hz info list pub type",
    "wtf": "hello",
}


def exists(path: Sequence[str]) -> bool:
    """Whether ``ros2`` has a verb, given as one word (``action``) or two (``topic``, ``list``)."""
    verb, *rest = path
    return verb in VERBS and (not rest or rest[0] in VERBS[verb].split())
