"""What can be told of anybody's description."""

from teleopctl.robot import with_absolute_mesh_paths, xacro_arguments

XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="$(arg name)">
  <xacro:arg name="tall" default="1.5"/>
  <xacro:arg  default='' name='prefix' />
  <!-- <xacro:arg name="gone"/> -->
  <xacro:arg name="kind"/>
</robot>"""


def test_the_arguments_of_a_description_are_those_that_it_declares_and_those_that_it_uses(tmp_path):
    (tmp_path / "a.xacro").write_text(XACRO)
    (tmp_path / "b.xacro").write_text('<robot><xacro:arg name="tall" default="2"/></robot>')
    files = [tmp_path / "a.xacro", tmp_path / "b.xacro", tmp_path / "none"]
    assert xacro_arguments(files) == {"name": None, "tall": "1.5", "prefix": "", "kind": None}


def test_meshes_beside_the_file_are_named_by_their_whole_paths(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a b.stl").touch()
    kept = (
        '<mesh filename="package://p/meshes/x.stl"/><mesh filename="/abs/x.stl"/>'
        '<mesh filename="meshes/none.stl"/><mesh filename=""/>'
    )
    text = f"<robot>{kept}<mesh scale='1 1 1' filename='meshes/a b.stl'/></robot>"
    uri = (tmp_path / "meshes" / "a b.stl").resolve().as_uri()
    assert with_absolute_mesh_paths(text, tmp_path) == (
        f"<robot>{kept}<mesh scale='1 1 1' filename='{uri}'/></robot>"
    )
