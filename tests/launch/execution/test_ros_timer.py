"""A ``ros_timer`` that follows ``/clock``."""

LAUNCH = """launch:
- arg: {name: who, default: robots}
- set_use_sim_time: {value: true}
- ros_timer:
    period: 5.0
    children: [log: {message: "the time of $(var who) has come"}]
- ros_timer:
    period: 5000.0
    children: [log: {message: never}]
"""


def test_it_waits_for_simulated_time_and_the_end_of_the_launch_cancels_it(ros):
    (ros.folder / "file.yaml").write_text(LAUNCH)
    launch = ros.spawn("launch file.yaml")
    launch.wait_for_line("Default logging verbosity")
    clock = ros.spawn("topic pub -r 20 /clock rosgraph_msgs/msg/Clock '{clock: {sec: 9}}'")
    launch.wait_for_line(r"^\[INFO\] \[launch.user\]: the time of robots has come$")
    clock.interrupt()
    launch.interrupt()
    assert launch.wait() == 0
    assert "never" not in launch.stdout
