"""A robot's report as JSON."""

from typing import TYPE_CHECKING

from teleopctl.cli import console

if TYPE_CHECKING:
    from teleopctl.nodes.checking.report import RobotReport

_SENTENCES = ("repaired", "guessed", "without_effect", "unknown")


def document(report: "RobotReport") -> console.Json:
    """Return a robot's report as JSON; see docs/json.md."""
    description = report.description
    trial, driven, frames = report.trial, report.driven, report.frames
    return {
        "file": str(report.file),
        "kind": report.kind,
        "error": report.error,
        "refusal": report.refusal,
        "fault": report.fault or None,
        "name": report.world or None if description is None else description.name,
        "root": None if description is None else description.root,
        "links": list(report.things if description is None else description.links),
        "joints": []
        if description is None
        else [
            {"name": one.name, "type": one.type, "parent": one.parent, "child": one.child}
            for one in description.joints.values()
        ],
        "mass_kg": report.mass_kg,
        "packages": report.packages,
        "meshes": report.meshes,
        "systems": []
        if description is None or report.error
        else [
            {
                "name": system.name,
                "plugin": system.hardware_plugin_name,
                "joints": [
                    {
                        "name": joint.name,
                        "command_interfaces": [one.name for one in joint.command_interfaces],
                        "state_interfaces": [one.name for one in joint.state_interfaces],
                    }
                    for joint in system.joints
                ],
            }
            for system in description.ros2_control
        ],
        "controllers": report.controllers,
        **{attribute: getattr(report, attribute) for attribute in _SENTENCES},
        "trial": None
        if trial is None
        else {
            "verdict": trial.verdict,
            "fault": trial.fault or None,
            "moved": list(trial.moved),
            "unmoved": list(trial.unmoved),
            "blocked": list(trial.blocked),
            "travelled_m": trial.travelled_m,
        },
        "driven": None
        if driven is None
        else {
            "own": driven.own,
            "verdict": driven.verdict,
            "fault": driven.why_not or None,
            "motions": [motion._asdict() for motion in driven.motions],
            "inactive": driven.inactive,
        },
        "frames": None if frames is None else frames._asdict(),
    }
