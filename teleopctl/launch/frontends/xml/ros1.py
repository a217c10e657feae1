"""Tells a launch file of ROS 1 from one of ROS 2, and says what its lines would be in ROS 2."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from teleopctl.errors import LaunchError
from teleopctl.launch.frontends.xml.tree import XmlTag
from teleopctl.launch.model.element import Element

_SUBSTITUTION = re.compile(r"(?<!\\)\$\(\s*(find|arg)\s+([^\s()]+)")
# What a launch file of ROS 1 cannot hold.
_OF_ROS_2 = re.compile(r"(?<!\\)\$\(\s*(var|find-pkg-\w+)\s")
_IN_ROS_2 = {"find": "find-pkg-share", "arg": "var"}

_TAGS = {
    "rosparam": "<param from=…/> in a node",
    "machine": "one launch on each machine",
    "test": "a test in Python with launch_testing",
}
_OUTSIDE_OF_NODES = {
    "param": "<set_parameter name=… value=…/>, or <param> in a node,",
    "remap": "<set_remap from=… to=…/>",
    "env": "<set_env name=… value=…/>",
}
_ATTRIBUTES = {
    ("node", "type"): "<node exec=…>",
    ("node", "ns"): "<node namespace=…>",
    ("group", "ns"): "<push_ros_namespace namespace=…/> in the group",
    ("include", "ns"): "<push_ros_namespace namespace=…/> in a group around it",
    ("include", "pass_all_args"): "needless, since the included file sees every argument,",
    ("arg", "doc"): "<arg description=…>",
}


class _Sign(NamedTuple):
    """A line that ROS 2 would not have.

    Attributes:
        element: What stands there.
        text: What it is, and what it would be in ROS 2.
        is_proof: Whether it is of ROS 1 for certain; else it may be a mistake in ROS 2.
    """

    element: Element
    text: str
    is_proof: bool


def refuse_ros1(root: XmlTag) -> None:
    """Refuse a launch file of ROS 1.

    Raises:
        LaunchError: It is one; the message names the first line and what it would be in ROS 2.
    """
    signs = list(_signs(root))
    is_certain = any(sign.is_proof for sign in signs)
    if not signs or (not is_certain and _is_of_ros_2(root)):
        return
    first, *others = sorted(signs, key=lambda sign: sign.element.place.line)
    lines = sorted({sign.element.place.line for sign in others} - {first.element.place.line})
    raise LaunchError(
        f"{first.element.place}: this is a launch file of ROS 1: {first.text} in ROS 2",
        hint=f"Its other lines of ROS 1: {', '.join(map(str, lines))}." if lines else None,
    )


def _signs(tag: XmlTag) -> Iterator[_Sign]:
    for name, element in tag.attributes.items():
        if (known := _ATTRIBUTES.get((tag.name, name))) is not None:
            proof = name == "type" and "exec" not in tag.attributes
            yield _Sign(element, f"<{tag.name} {name}=…> is {known}", proof)
        # A description is shown as it stands.
        if name != "description" and isinstance(element.value, str):
            for word, argument in _SUBSTITUTION.findall(element.value):
                text = f"$({word} {argument}) is $({_IN_ROS_2[word]} {argument})"
                yield _Sign(element, text, is_proof=True)
    for nested in tag.nested:
        if nested.name == "arg" and tag.name != "include" and "value" in nested.attributes:
            value = nested.attributes["value"]
            yield _Sign(value, "<arg value=…> is <let name=… value=…/>", is_proof=False)
        if nested.name in _TAGS:
            yield _Sign(nested, f"<{nested.name}> is {_TAGS[nested.name]}", is_proof=True)
        elif nested.name in _OUTSIDE_OF_NODES and tag.name in ("launch", "group"):
            text = f"<{nested.name}> outside of a node is {_OUTSIDE_OF_NODES[nested.name]}"
            yield _Sign(nested, text, is_proof=False)
        yield from _signs(nested)


def _is_of_ros_2(tag: XmlTag) -> bool:
    """Whether something stands in a tag that ROS 1 does not have."""
    if tag.name == "node" and "exec" in tag.attributes:
        return True
    texts = (element.value for element in tag.attributes.values())
    if any(isinstance(text, str) and _OF_ROS_2.search(text) for text in texts):
        return True
    return any(map(_is_of_ros_2, tag.nested))
