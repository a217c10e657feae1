"""The robot is reloaded when its description or a mesh is saved; real processes, no browser."""

import re
from pathlib import Path

import pytest

from teleopctl.testing import RosGraph, eventually

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
SIZES = f'<robot {XACRO}><xacro:property name="r" value="0.1"/></robot>'
MODEL = f"""<robot name="r" {XACRO}>
<xacro:include filename="sizes.xacro"/>
<link name="a"><visual><geometry><sphere radius="${{r}}"/></geometry></visual></link>
</robot>"""


@pytest.fixture
def model(ros: RosGraph) -> Path:
    (ros.folder / "sizes.xacro").write_text(SIZES)
    path = ros.folder / "model.urdf.xacro"
    path.write_text(MODEL)
    return path


def save(path: Path, text: str) -> None:
    """As editors do: a new file in the place of the old one."""
    new = path.with_suffix(".new")
    new.write_text(text)
    new.replace(path)


def radius(ros: RosGraph) -> list[str]:
    done = ros.run("param get /robot_state_publisher robot_description")
    return re.findall(r'radius="([^"]*)"', done.stdout)


def page_log(ros: RosGraph) -> str:
    return ros.run("logs rviz").stdout


def test_a_saved_description_is_the_robot_of_all_and_a_broken_one_is_told(ros, model):
    done = ros.run(["launch", "--detach", "display.yaml", f"model:={model}", "viewer:=true"], 60)
    assert done.returncode == 0, done.stderr
    assert radius(ros) == ["0.1"]

    def reloaded(text: str, expected: str) -> bool:
        # saved again until the page has begun to watch
        save(model.with_name("sizes.xacro"), text)
        return radius(ros) == [expected]

    eventually(lambda: reloaded(SIZES.replace("0.1", "0.2"), "0.2"))
    save(model, MODEL.replace("${r}", "${nothing}"))
    eventually(lambda: "model.urdf.xacro:3: name 'nothing' is not defined" in page_log(ros))
    save(model, MODEL.replace("<link", '<link name="stray"/><link'))
    eventually(lambda: "not reloaded: Two root links found" in page_log(ros))
    assert radius(ros) == ["0.2"]
    save(model, MODEL.replace("${r}", "0.3"))
    eventually(lambda: radius(ros) == ["0.3"])


@pytest.mark.nightly
def test_in_simulation_the_page_says_that_the_robot_stays(ros, model):
    ros.launch("display.yaml", f"model:={model}", "viewer:=false")
    words = ["-p", f"robot_description_file:={model}", "-p", "use_sim_time:=true"]
    done = ros.run(["run", "--detach", "rviz2", "rviz2", "--ros-args", *words], 60)
    assert done.returncode == 0, done.stderr

    def told() -> bool:
        save(model.with_name("sizes.xacro"), SIZES.replace("0.1", "0.2"))
        return "the running simulation keeps the old robot" in ros.run("logs rviz2").stdout

    eventually(told)
    assert radius(ros) == ["0.1"]
