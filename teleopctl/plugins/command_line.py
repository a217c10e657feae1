"""The verbs of the command line and the completions of their words.

In a module of their own, since every command loads them, and few load another kind of plug-in.
"""

from __future__ import annotations

from teleopctl.plugins.lookup import Kind

_VERBS = {
    "run": ("run:VERB", "Start one node."),
    "python": ("python:VERB", "Start Python with rclpy to import."),
    "launch": ("launch:VERB", "Start nodes from a launch file."),
    "view": ("view:VERB", "Open the robot's page in the browser."),
    "test": ("test:VERB", "Run launch tests."),
    "ps": ("ps:VERB", "List background processes."),
    "logs": ("logs:VERB", "Show the output of a background process."),
    "stop": ("stop:VERB", "Stop background processes."),
    "top": ("top:VERB", "Watch processes, topics, controllers and the log."),
    "topic": ("topic:GROUP", "List, print, measure and publish topics."),
    "node": ("node:GROUP", "List nodes and their endpoints."),
    "graph": ("graph:VERB", "Draw the graph of nodes and topics."),
    "bag": ("bag:GROUP", "Record, play and inspect bags."),
    "episode": ("episode:GROUP", "Record and edit episodes for training."),
    "param": ("param:GROUP", "Read and change parameters of nodes."),
    "service": ("service:GROUP", "List, call and watch services."),
    "action": ("action:GROUP", "List actions, send goals and watch them."),
    "pkg": ("pkg:GROUP", "Find packages."),
    "component": ("component:GROUP", "Load nodes into containers."),
    "lifecycle": ("lifecycle:GROUP", "Manage the states of managed nodes."),
    "control": ("control:GROUP", "Manage controllers and hardware."),
    "robot": ("robot:GROUP", "Check robots' files."),
    "move": ("move:VERB", "Move an arm, or its gripper."),
    "kinematics": ("kinematics:GROUP", "Compute poses and joint positions of arms."),
    "sim": ("sim:GROUP", "Run simulations."),
    "drive": ("drive:VERB", "Drive a robot by hand on a page."),
    "camera": ("camera:GROUP", "Save pictures of cameras."),
    "tf": ("tf:GROUP", "Watch transforms between frames."),
    "interface": ("interface:GROUP", "Use definitions of messages, services and actions."),
    "doctor": ("doctor:GROUP", "Check the setup for problems."),
    "wtf": ("doctor:GROUP", "Alias of doctor."),
    "multicast": ("multicast:GROUP", "Send and receive datagrams to many machines."),
    "plugin": ("extensions:PLUGIN", "List plug-ins by their packages."),
    "extensions": ("extensions:EXTENSIONS", "List plug-ins, built-in and installed ones."),
    "extension_points": ("extensions:EXTENSION_POINTS", "List the kinds of plug-ins."),
    "daemon": ("daemon:GROUP", "Manage the router through which nodes discover each other."),
    "rviz": ("view:VERB", "Alias of view."),
    "rviz2": ("view:VERB", "Alias of view."),
    "gui": ("view:VERB", "Alias of view."),
    "completion": ("completion:GROUP", "Print the completion script of a shell."),
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
        "topics": f"{_CANDIDATES}:topics",
        "transitions": f"{_NOUNS}.lifecycle:complete_transitions",
    },
    direct=True,
)
"""Shell completions: functions that return the completions of an incomplete word."""
