"""Types that are learnt from other nodes."""

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import store
from teleopctl.interfaces.foreign.description import definitions
from teleopctl.interfaces.hashing import fields_of
from tests.samples import sample

PACKAGE = "type_description_interfaces/msg"
FieldType = store.get_message(f"{PACKAGE}/FieldType")
Field = store.get_message(f"{PACKAGE}/Field")
Individual = store.get_message(f"{PACKAGE}/IndividualTypeDescription")
TypeDescription = store.get_message(f"{PACKAGE}/TypeDescription")


def individual(entry):
    return Individual(
        type_name=entry["type_name"],
        fields=[Field(name=f["name"], type=FieldType(**f["type"])) for f in entry["fields"]],
    )


def described(type_name):
    description = store.type_description(type_name)
    return TypeDescription(
        type_description=individual(description["type_description"]),
        referenced_type_descriptions=[
            individual(entry) for entry in description["referenced_type_descriptions"]
        ],
    )


def test_types_survive_their_description():
    for name in sample(store.list_types(), 5):
        for definition in definitions(described(name)):
            known = store.known_types().find(definition.type_name)
            assert known is not None
            assert fields_of(known) == fields_of(definition)


def test_an_unknown_type_becomes_known():
    description = described("sensor_msgs/msg/JointState")
    description.type_description.type_name = "learnt_msgs/msg/Joints"
    store.add_description(description)
    joints = store.get_message("learnt_msgs/msg/Joints")
    assert joints(name=["a"], position=[1.0]).header.frame_id == ""


def test_a_known_type_must_be_the_same():
    description = described("std_msgs/msg/String")
    store.add_description(description)
    description.type_description.fields[0].name = "text"
    with pytest.raises(TeleopctlError, match="defined here differently"):
        store.add_description(description)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("x", FieldType(type_id=0)),
        ("x", FieldType(type_id=13)),
        ("x", FieldType(type_id=250)),
        ("x", FieldType(type_id=1)),
        ("x", FieldType(type_id=1, nested_type_name="nonsense")),
        ("x", FieldType(type_id=51)),
        ("x", FieldType(type_id=21)),
        ("x y", FieldType(type_id=2)),
        ("_x", FieldType(type_id=2)),
        ("TYPE_NAME", FieldType(type_id=2)),
    ],
)
def test_nonsense_is_refused(name, kind):
    description = TypeDescription(
        type_description=Individual(
            type_name="strange_msgs/msg/Strange", fields=[Field(name=name, type=kind)]
        )
    )
    with pytest.raises(TeleopctlError):
        store.add_description(description)


def test_a_complete_text_has_every_type_once():
    text = store.complete_definition_text("geometry_msgs/msg/TransformStamped")
    parts = text.split("=" * 80 + "\n")
    assert [part.splitlines()[0] for part in parts[1:]] == [
        "MSG: std_msgs/Header",
        "MSG: geometry_msgs/Transform",
        "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/Vector3",
        "MSG: geometry_msgs/Quaternion",
    ]


def test_complete_texts_are_understood_by_rosbags():
    types = get_types_from_msg(
        store.complete_definition_text("sensor_msgs/msg/CameraInfo"), "sensor_msgs/msg/CameraInfo"
    )
    known = get_typestore(Stores.ROS2_JAZZY)
    for name, (_constants, fields) in types.items():
        assert fields == known.fielddefs[name][1]
