"""What a description asks a simulator for and does not get: one warning for each tag."""

from __future__ import annotations

from lxml import etree

# Tags of <gazebo reference="…"> that have their effect, or that change nothing of a simulation.
_SERVED = frozenset({"material", "mu1", "mu2", "sensor"})

# Tags of a <sensor> that have their effect; `visualize` and `always_on` are for Gazebo's window.
_SERVED_BY_SENSORS = frozenset(
    {"update_rate", "topic", "frame_id", "gz_frame_id", "pose", "plugin", "camera", "imu"}
    | {"always_on", "visualize", "ignition_frame_id"}
)

# What a link has anyway if the tag says so.
_HARMLESS = {"gravity": ("true", "1"), "turnGravityOff": ("false", "0")} | dict.fromkeys(
    ("selfCollide", "self_collide"), ("true", "1")
)


def unserved_tags(urdf: str) -> list[str]:
    """One sentence for each tag of the description that the simulation leaves out.

    Args:
        urdf: The expanded robot description, which is well formed.
    """
    # Whatever was said of the text's encoding, it is decoded by now.
    parser = etree.XMLParser(encoding="utf-8", resolve_entities=False, remove_comments=True)
    robot = etree.fromstring(urdf.encode(), parser)
    known = {element.get("name") for kind in ("link", "joint") for element in robot.iterfind(kind)}
    warnings = []
    for gazebo in robot.iterfind("gazebo"):
        reference = gazebo.get("reference")
        if not reference:
            continue
        if reference not in known:
            warnings.append(
                f"<gazebo> (line {gazebo.sourceline}) is left out: there is no link or joint "
                f"'{reference}'"
            )
            continue
        where = f"'{reference}'"
        for tag in gazebo:
            name, text = str(tag.tag), (tag.text or tag.get("value") or "").strip()
            if name == "mu2" and text != gazebo.findtext("mu1", text).strip():
                warnings.append(
                    f"<mu2> of {where} (line {tag.sourceline}) is left out: friction is <mu1> in "
                    "all directions"
                )
            elif name == "sensor":
                warnings += _of_sensor(tag)
            elif name not in _SERVED and text.lower() not in _HARMLESS.get(name, ()):
                warnings.append(f"<{name}> of {where} (line {tag.sourceline}) has no effect")
    return warnings


def _of_sensor(sensor: etree._Element) -> list[str]:
    where = f"of sensor '{sensor.get('name')}'"
    found = [tag for tag in sensor if str(tag.tag) not in _SERVED_BY_SENSORS]
    found += sensor.findall(".//noise")
    return [f"<{tag.tag}> {where} (line {tag.sourceline}) has no effect" for tag in found]
