"""The verbs of the command line and the completions of their words.

In a module of their own, since every command loads them, and few load another kind of plug-in.
"""

from __future__ import annotations

from teleopctl.plugins.lookup import Kind

_VERBS = {
    "run": ("run:VERB", "Start one node."),
    "launch": ("launch:VERB", "Start nodes from a launch file."),
    "ps": ("ps:VERB", "List background processes."),
    "logs": ("logs:VERB", "Show the output of a background process."),
    "stop": ("stop:VERB", "Stop background processes and nodes, or the robot."),
    "view": ("view:VERB", "Open the robot's page in the browser."),
    "top": ("top:VERB", "Watch processes, topics, controllers and the log."),
    "graph": ("graph:VERB", "Draw the graph of nodes and topics."),
    "camera": ("camera:GROUP", "Save pictures of cameras."),
    "topic": ("topic:GROUP", "List, print, measure and publish topics."),
    "node": ("node:GROUP", "List nodes and their endpoints, and end nodes."),
    "service": ("service:GROUP", "List, call and watch services."),
    "action": ("action:GROUP", "List actions; send, watch and cancel goals."),
    "param": ("param:GROUP", "Read and change parameters of nodes."),
    "logger": ("logger:GROUP", "Read, change and watch the logging of nodes."),
    "tf": ("tf:GROUP", "Watch transforms between frames."),
    "interface": ("interface:GROUP", "Use definitions of messages, services and actions."),
    "doctor": ("doctor:GROUP", "Check the setup for problems."),
    "move": ("move:VERB", "Move an arm, or its gripper."),
    "drive": ("drive:VERB", "Drive a robot by hand on a page."),
    "control": ("control:GROUP", "Manage controllers and hardware."),
    "kinematics": ("kinematics:GROUP", "Compute poses and joint positions of arms."),
    "bag": ("bag:GROUP", "Record, play and inspect bags."),
    "episode": ("episode:GROUP", "Record and edit episodes for training."),
    "robot": ("robot:GROUP", "Check robots' files."),
    "sim": ("sim:GROUP", "Run simulations."),
    "pkg": ("pkg:GROUP", "Create and find packages."),
    "python": ("python:VERB", "Start Python with rclpy to import."),
    "test": ("test:VERB", "Run launch tests."),
    "wait": ("wait:GROUP", "Wait for nodes, topics and so on, in scripts."),
    "lifecycle": ("lifecycle:GROUP", "Manage the states of managed nodes."),
    "component": ("component:GROUP", "Load nodes into containers."),
    "daemon": ("daemon:GROUP", "Manage the router through which nodes discover each other."),
    "completion": ("completion:GROUP", "Print the completion script of a shell."),
    "ros2": ("ros2:GROUP", "Make the word ros2 work in this environment."),
    "help": ("about:HELP", "Explain a verb."),
    "version": ("about:VERSION", "Print the version."),
    "plugin": ("extensions:PLUGIN", "List plug-ins by their packages."),
    "gui": ("view:VERB", "Alias of view."),
    "rviz": ("view:VERB", "Alias of view."),
    "rviz2": ("view:VERB", "Alias of view."),
    "wtf": ("doctor:GROUP", "Alias of doctor."),
    "extensions": ("extensions:EXTENSIONS", "List plug-ins, built-in and installed ones."),
    "extension_points": ("extensions:EXTENSION_POINTS", "List the kinds of plug-ins."),
    "multicast": ("multicast:GROUP", "Send and receive datagrams to many machines."),
}

VERBS = Kind(
    "verb",
    "teleopctl.verbs",
    {name: f"teleopctl.cli.verbs.{target}" for name, (target, _) in _VERBS.items()},
    bases=("teleopctl.cli.verb:Verb", "teleopctl.cli.verb:VerbGroup"),
    classes=False,
    summaries={name: summary for name, (_, summary) in _VERBS.items()},
)
"""Commands of ``teleopctl``, by name."""

_NOUNS = "teleopctl.cli.verbs"
_COMPLETION = "teleopctl.cli.completion"
_CANDIDATES = f"{_COMPLETION}.candidates"
_ROBOTS = f"{_NOUNS}.kinematics.source"

COMPLETIONS = Kind(
    "completion",
    "teleopctl.completions",
    {
        "action_types": f"{_NOUNS}.action:complete_types",
        "actions": f"{_NOUNS}.action:complete_actions",
        "all_links": f"{_ROBOTS}:complete_all_links",
        "active_controllers": f"{_NOUNS}.control.manager:complete_active_controllers",
        "bags": f"{_NOUNS}.bag.options:complete_bags",
        "component_ids": f"{_NOUNS}.component:complete_ids",
        "component_packages": f"{_NOUNS}.component:complete_packages",
        "component_types": f"{_NOUNS}.component:complete_types",
        "containers": f"{_NOUNS}.component:complete_containers",
        "controller_managers": f"{_NOUNS}.control.manager:complete_managers",
        "controllers": f"{_NOUNS}.control.manager:complete_controllers",
        "fields": f"{_COMPLETION}.messages:fields",
        "files": f"{_CANDIDATES}:files",
        "frames": f"{_NOUNS}.tf:complete_frames",
        "groups": f"{_ROBOTS}:complete_groups",
        "hardware_components": f"{_NOUNS}.control.manager:complete_hardware_components",
        "inactive_controllers": f"{_NOUNS}.control.manager:complete_inactive_controllers",
        "interface_packages": f"{_NOUNS}.interface:complete_packages",
        "interface_types": f"{_NOUNS}.interface:complete_types",
        "joints": f"{_ROBOTS}:complete_joints",
        "launch_words": f"{_CANDIDATES}:launch_words",
        "licenses": f"{_NOUNS}.pkg:complete_licenses",
        "links": f"{_ROBOTS}:complete_links",
        "loadable_controllers": f"{_NOUNS}.control.manager:complete_loadable_controllers",
        "logged_processes": f"{_CANDIDATES}:logged_processes",
        "managed_nodes": f"{_NOUNS}.lifecycle:complete_managed_nodes",
        "manifest_tags": f"{_NOUNS}.pkg:complete_manifest_tags",
        "message_types": f"{_COMPLETION}.messages:message_types",
        "named_states": f"{_ROBOTS}:complete_named_states",
        "nodes": f"{_CANDIDATES}:nodes",
        "packages": f"{_CANDIDATES}:package_names",
        "parameter_names": f"{_NOUNS}.param.candidates:parameter_names",
        "parameter_values": f"{_NOUNS}.param.candidates:parameter_values",
        "programs": f"{_CANDIDATES}:programs",
        "prototypes": f"{_COMPLETION}.messages:prototypes",
        "running_processes": f"{_CANDIDATES}:running_processes",
        "service_types": f"{_COMPLETION}.messages:service_types",
        "services": f"{_CANDIDATES}:services",
        "teleop_devices": f"{_NOUNS}.drive:complete_devices",
        "topics": f"{_CANDIDATES}:topics",
        "transitions": f"{_NOUNS}.lifecycle:complete_transitions",
    },
    direct=True,
)
"""Shell completions: functions that return the completions of an incomplete word."""
