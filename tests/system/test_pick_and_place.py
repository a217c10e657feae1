"""The teleop arm takes a cube from a table into a bin, by friction."""


def test_a_cube_is_taken_into_the_bin(ros):
    launch = ros.spawn("launch pick_and_place.yaml camera:=false times:=1 real_time_factor:=4")
    launch.wait_for_line(r"1 of 1: the cube is in the bin")
    launch.wait_for_line(r"1 of 1 cubes are in the bin")
    launch.wait_for_line(r"pick_and_place-\d+\]: process has finished cleanly")


def test_another_robot_is_refused(ros):
    robot = ros.folder / "pole.urdf"
    robot.write_text('<robot name="pole"><link name="base"/></robot>')
    ros.launch("display.yaml", f"model:={robot}", "viewer:=false")
    done = ros.run("run pick_and_place")
    assert done.returncode == 1
    assert "The robot 'pole' is not the teleop arm" in done.stderr
