"""MJCF files that ask for more than a machine has are refused before MuJoCo reads them."""

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import build_model
from teleopctl.robot import (
    RobotDescription,
    check_mjcf,
    load_mjcf,
    read_model,
    read_world,
    read_world_text,
)

BODY = '<body name="b"><joint name="j"/><geom size="0.1"/></body>'


@pytest.fixture
def write(tmp_path):
    def write(inside, name="robot.xml"):
        path = tmp_path / name
        path.write_text(f"<mujoco>\n{inside}\n</mujoco>")
        return path

    return write


TOO_MUCH = {
    '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>': (
        "<hfield name='h'> has 1e+10 cells, and 16,000,000 are the most"
    ),
    '<worldbody><replicate count="10000000"><geom size="1"/></replicate></worldbody>': (
        "<replicate> makes 1e+07 elements, and 10,000 are the most"
    ),
    "<worldbody>"
    + 9 * '<replicate count="10"><frame>'
    + '<geom size="1"/>'
    + 9 * "</frame></replicate>"
    + "</worldbody>": "elements, and 10,000 are the most",
    '<asset><texture name="t" builtin="flat" width="100000" height="100000"/></asset>': (
        "<texture name='t'> has 1e+10 pixels"
    ),
    '<worldbody><body name="b"><flexcomp name="f" count="1000 1000 1000"/></body></worldbody>': (
        "<flexcomp name='f'> has 1e+09 points"
    ),
    '<worldbody><body name="b"><composite count="100 100 100"/></body></worldbody>': (
        "<composite> has 1e+06 parts"
    ),
    '<asset><mesh name="m" builtin="plate" params="9000 9000"/></asset>': (
        "<mesh name='m'> has 8.1e+07 points"
    ),
    '<sensor><user dim="1000000000"/></sensor>': "<user> has 1e+09 numbers",
    '<size nuser_body="1000000000"/>': "<size> requests 1e+09 numbers in nuser_body",
}


@pytest.mark.parametrize("inside", TOO_MUCH)
def test_what_would_fill_the_memory_is_refused_with_its_line(write, inside):
    path = write(inside)
    with pytest.raises(InvalidDescriptionError) as refused:
        load_mjcf(path)
    assert refused.value.message.startswith(f"{path}:2: ")
    assert TOO_MUCH[inside] in refused.value.message


def test_what_is_included_or_attached_counts_as_often_as_it_is_there(write, tmp_path):
    (tmp_path / "parts").mkdir()
    write(f'<worldbody><replicate count="200">{BODY}</replicate></worldbody>', "parts/many.xml")
    once = write('<include file="parts/many.xml"/>', "once.xml")
    check_mjcf(once)
    inside = '<worldbody><replicate count="200"><include file="parts/many.xml"/></replicate>'
    with pytest.raises(InvalidDescriptionError, match=r"robot.xml:2: <replicate> makes"):
        load_mjcf(write(f"{inside}</worldbody>"))
    model = '<asset><model name="m" file="parts/many.xml"/></asset>'
    attach = '<replicate count="200"><attach model="m" body="b" prefix="x"/></replicate>'
    with pytest.raises(InvalidDescriptionError, match=r"robot.xml:2: <replicate> makes"):
        load_mjcf(write(f"{model}<worldbody>{attach}</worldbody>"))
    write('<asset><hfield nrow="9999" ncol="9999" size="1 1 1 1"/></asset>', "parts/high.xml")
    with pytest.raises(InvalidDescriptionError, match=r"high.xml:2: <hfield> has 9\.998e\+07"):
        load_mjcf(write('\n<include file="parts/high.xml"/>'))


def test_a_world_of_mujocos_is_looked_at_as_a_robot_is(write):
    inside, told = next(iter(TOO_MUCH.items()))
    path = write(inside)
    robot = RobotDescription.from_urdf('<robot name="r"><link name="l"/></robot>')
    for world in (read_world(path), read_world_text(path.read_text(), "text")):
        with pytest.raises(InvalidDescriptionError) as refused:
            build_model(robot, None, world)
        assert told in refused.value.message


def test_what_files_have_is_read(write):
    inside = (
        '<asset><hfield name="h" nrow="200" ncol="200" size="1 1 1 1"/></asset><worldbody>'
        f'<replicate count="20" offset="0 0 1"><geom size="0.1"/></replicate>{BODY}</worldbody>'
    )
    assert load_mjcf(write(inside)).model.ngeom == 21
    assert read_model(write(inside)).text


def test_what_is_no_xml_and_files_that_include_themselves_are_mujocos_to_refuse(write):
    for inside in ('<include file="robot.xml"/>', "<worldbody>", '<include file="none.xml"/>'):
        with pytest.raises(InvalidDescriptionError, match="MuJoCo refuses it"):
            load_mjcf(write(inside))
