"""Interfaces that are defined in ``.idl`` files."""

import pytest

from teleopctl.errors import InvalidDefinitionError
from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.definition import Definition, FieldType, Shape
from teleopctl.interfaces.foreign.idl import idl_includes, read_idl, split_idl
from teleopctl.interfaces.services import split_definition

THING = """\
// What stands in a package of somebody.
#include "geometry_msgs/msg/Point.idl"
module my_pkg {
  module msg {
    module Thing_Constants {
      const long MOST = 3;
      const string TITLE = "a \\"b\\"";
    };
    @verbatim (language="comment", text="What it is." "\\n" "Twice.")
    struct Thing {
      @default (value=7) @unit (value="m")
      unsigned long count;
      @verbatim (language="comment", text="Where.")
      geometry_msgs::msg::Point place;
      @default (value="(1.5, -2, 3)")
      double numbers[3];
      sequence<string<5>> names;
      sequence<octet, 4> data;
      @default (value=TRUE)
      boolean ok;
      @default (value=1.5d)
      float one, two;
      wstring<MOST> wide;
    };
  };
};
"""
AS_MSG = """\
# What it is.
# Twice.
int32 MOST=3
string TITLE='a "b"'
uint32 count 7
# Where.
geometry_msgs/Point place
float64[3] numbers [1.5, -2, 3]
string<=5[] names
byte[<=4] data
bool ok true
float32 one 1.5
float32 two 1.5
wstring<=3 wide
"""
SERVICE = """\
module my_pkg { module srv {
  module Go_Request_Constants { const uint8 FAST = 1; };
  struct Go_Request { uint8 how; };
  struct Go_Response { uint8 structure_needs_at_least_one_member; };
}; };
"""
ACTION = """\
module my_pkg { module action {
  struct Walk_Goal { float distance; };
  struct Walk_Result { boolean arrived; };
  struct Walk_Feedback { my_pkg::msg::Thing seen; };
}; };
"""


def content(definitions: list[Definition]) -> list[Definition]:
    return [definition._replace(text=None) for definition in definitions]


def test_a_message_is_the_one_that_the_same_lines_in_a_msg_file_define():
    found = split_idl(THING, "my_pkg/msg/Thing", "Thing.idl")
    assert found[0].render() == AS_MSG
    assert content(found) == content(split_definition(AS_MSG, "my_pkg/msg/Thing"))
    assert idl_includes(THING) == ["geometry_msgs/msg/Point.idl"]


@pytest.mark.parametrize(
    ("text", "name", "written"),
    [
        (SERVICE, "my_pkg/srv/Go", "uint8 FAST=1\nuint8 how\n---\n"),
        (
            ACTION,
            "my_pkg/action/Walk",
            "float32 distance\n---\nbool arrived\n---\nmy_pkg/Thing seen\n",
        ),
    ],
)
def test_a_service_and_an_action_have_all_their_parts(text, name, written):
    found = split_idl(text, name, "file.idl")
    assert content(found) == content(split_definition(written, name))
    assert found[-1].render() == written


def test_a_package_may_have_files_of_either_form(tmp_path, monkeypatch):
    folder = tmp_path / "my_pkg"
    for name, text in {
        "msg/Thing.idl": THING,
        "msg/Plain.msg": "int32 number\n",
        "msg/Plain.idl": "what a build makes of the other is not read",
        "srv/Go.idl": SERVICE,
        "action/Walk.idl": ACTION,
        "package.xml": "<package format='3'><name>my_pkg</name></package>",
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    catalog = Catalog(cached=False)
    assert catalog.package_names("my_pkg") == [
        "my_pkg/action/Walk",
        "my_pkg/msg/Plain",
        "my_pkg/msg/Thing",
        "my_pkg/srv/Go",
    ]
    response, thing = catalog.find("my_pkg/srv/Go_Response"), catalog.find("my_pkg/msg/Thing")
    assert response is not None
    assert response.fields == ()
    assert thing is not None
    assert thing.nested_types() == ["geometry_msgs/msg/Point"]
    assert catalog.file("my_pkg/msg/Thing") == folder / "msg" / "Thing.idl"
    names = catalog.package_names("my_pkg")  # all of them, though some have been read
    assert sorted(Catalog(cached=False).add_folder(folder, "my_pkg")) == names


@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ("boolean? ok", "boolean ok", r"Thing.idl:20: this is no IDL: '\? ok;'"),
        ("char ok", "boolean ok", "Thing.idl:20: ok: char is not served in messages"),
        ("long double ok", "boolean ok", "Thing.idl:20: ok: long double is not served"),
        ("boolean Ok", "boolean ok", "Thing.idl:20: Ok: the name of a field begins with a small"),
        ("double numbers[NOPE]", "double numbers[3]", "Thing.idl: Cannot resolve constant 'NOPE'"),
        (
            "value=3",
            'value="(1.5, -2, 3)"',
            "Thing.idl:16: numbers: the default of an array",
        ),
        ("numbers[0]", "numbers[3]", "Thing.idl:16: numbers: the size of an array is a positive"),
        ("octet B = 300; const long", "long", "Thing.idl:6: B: 300 is out of range"),
        ("long ok;", "boolean ok;", "Thing.idl:20: ok: invalid literal for int"),
        ("float one, one", "float one, two", "Thing.idl:22: one: the name is given twice"),
        ("module ms", "module msg", "Thing.idl: there is no struct my_pkg::msg::Thing"),
    ],
)
def test_what_cannot_be_served_is_told_with_its_line(wrong, right, said):
    with pytest.raises(InvalidDefinitionError, match=said):
        split_idl(THING.replace(right, wrong, 1), "my_pkg/msg/Thing", "Thing.idl")


def test_annotations_of_every_kind_are_kept():
    text = """module p { module msg {
      @transfer_mode(SHMEM_REF)
      struct M { @key @range (min=-10, max=1+1)
        sequence<p::msg::Other, 2> others; };
    }; };"""
    (struct,) = read_idl(text, "M.idl")
    assert struct.annotations == (("transfer_mode", "SHMEM_REF"),)
    (member,) = struct.members
    assert member.type == FieldType("p/msg/Other", Shape.BOUNDED, 2)
    assert member.annotations == (("key", None), ("range", {"min": -10, "max": 2}))
