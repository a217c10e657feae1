"""A bag over another one: times, stamps, topics and frames of the view."""

from teleopctl.bag import BagMessage, BagWriter, open_bag
from teleopctl.bag.overlaid import OverlaidBag
from teleopctl.interfaces import deserialize, get_message, serialize, set_stamp, to_nanoseconds
from tests.bag.bags import topic

JOINTS, TF = "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage"
SECOND_NS = 1_000_000_000


def write(folder, start_ns, lead_ns):
    """Write a bag with joint states and a chain of transforms, whose stamps lead by a time."""
    with BagWriter(folder) as writer:
        for name, kind in (("/joint_states", JOINTS), ("/tf", TF)):
            writer.add_topic(topic(name, kind))
        for number in range(3):
            time_ns = start_ns + number * SECOND_NS
            joints = get_message(JOINTS)(name=["hip"], position=[float(number)])
            set_stamp(joints.header.stamp, time_ns + lead_ns)
            transforms = get_message(TF)()
            for parent, child in (("world", "/base"), ("base", "arm")):
                one = get_message("geometry_msgs/msg/TransformStamped")(child_frame_id=child)
                one.header.frame_id = parent
                set_stamp(one.header.stamp, time_ns + lead_ns)
                transforms.transforms.append(one)
            for name, message in (("/joint_states", joints), ("/tf", transforms)):
                writer.write(BagMessage(name, time_ns, time_ns, bytes(serialize(message))))


def test_the_second_bag_starts_with_the_first_under_names_of_its_own(tmp_path):
    # The first has stamps of a simulation, the second those of its clock.
    write(tmp_path / "first", 5000 * SECOND_NS, -4990 * SECOND_NS)
    write(tmp_path / "second", 9000 * SECOND_NS, 0)
    with open_bag(tmp_path / "first") as below:
        bag = OverlaidBag(open_bag(tmp_path / "second"), below, "over")
        assert bag.metadata.start_ns == below.metadata.start_ns
        assert [one.name for one, _ in bag.metadata.topics] == ["/over/joint_states", "/tf"]
        (joints,) = bag.messages(["/over/joint_states"], 5001 * SECOND_NS, 5002 * SECOND_NS)
        decoded = deserialize(joints.data, get_message(JOINTS))
        assert (joints.log_time_ns, list(decoded.position)) == (5001 * SECOND_NS, [1.0])
        assert to_nanoseconds(decoded.header.stamp) == 11 * SECOND_NS
        (last,) = bag.latest("/tf", 5002 * SECOND_NS)
        parts = deserialize(last.data, get_message(TF)).transforms
        frames = [(one.header.frame_id, one.child_frame_id) for one in parts]
        # The root is the place of both robots.
        assert frames == [("world", "over/base"), ("over/base", "over/arm")]
        bag.close()
