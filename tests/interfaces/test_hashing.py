"""RIHS01 hashes against those of code that ROS 2's own generator made."""

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import hashing, store
from teleopctl.interfaces.definition import Definition, Field, FieldType, Shape
from tests.samples import sample

HASHES = {
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "std_msgs/msg/Empty": "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312",
    "std_msgs/msg/Bool": "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
    "std_msgs/msg/Char": "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
    "std_msgs/msg/Int32": "b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb",
    "std_msgs/msg/Float64": "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
    "std_msgs/msg/Float64MultiArray": (
        "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"
    ),
    "std_msgs/msg/Header": "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
    "builtin_interfaces/msg/Time": (
        "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"
    ),
    "sensor_msgs/msg/JointState": (
        "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    ),
    "sensor_msgs/msg/Image": "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    "sensor_msgs/msg/CameraInfo": (
        "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"
    ),
    "sensor_msgs/msg/CompressedImage": (
        "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a"
    ),
    "sensor_msgs/msg/Imu": "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    "sensor_msgs/msg/Joy": "0d356c79cad3401e35ffeb75a96a96e08be3ef896b8b83841d73e890989372c5",
    "tf2_msgs/msg/TFMessage": ("e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
    "geometry_msgs/msg/Twist": ("9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"),
    "geometry_msgs/msg/TwistStamped": (
        "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"
    ),
    "geometry_msgs/msg/PoseStamped": (
        "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"
    ),
    "geometry_msgs/msg/TransformStamped": (
        "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206"
    ),
    "trajectory_msgs/msg/JointTrajectory": (
        "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"
    ),
    "rosgraph_msgs/msg/Clock": ("692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"),
    "rcl_interfaces/msg/Log": ("e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac"),
    "rcl_interfaces/msg/ParameterEvent": (
        "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204"
    ),
    # Of public workspaces that were built.
    "dwb_msgs/msg/CriticScore": "4dfb083c8d33fde7d1e1482381507ff333b86233238880a8968210692cddab6f",
    "nav2_msgs/action/UndockRobot": (
        "fe446bf5f84bbdc08b5a1123365e3c9b1e522e50a412d64c36995f808df915a2"
    ),
    "nav_2d_msgs/msg/Twist2D": "33a3a47d7b3aaad5376a48250597093feb4b92ab8706c96dca69f47d9a9807d0",
    "px4_msgs/msg/VehicleOdometry": (
        "4295b96ad312084aa35c84bdcec65ba2f57eb4f6a293d57d52d95acbe99ff817"
    ),
    "action_msgs/msg/GoalStatusArray": (
        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"
    ),
    "diagnostic_msgs/msg/DiagnosticArray": (
        "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"
    ),
    "visualization_msgs/msg/MarkerArray": (
        "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"
    ),
    "service_msgs/msg/ServiceEventInfo": (
        "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45"
    ),
    "unique_identifier_msgs/msg/UUID": (
        "1b8e8aca958cbea28fe6ef60bf6c19b683c97a9ef60bb34752067d0f2f7ab437"
    ),
    "rcl_interfaces/srv/GetParameters": (
        "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc"
    ),
    "rcl_interfaces/srv/GetParameterTypes": (
        "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca"
    ),
    "rcl_interfaces/srv/SetParameters": (
        "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0"
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd"
    ),
    "rcl_interfaces/srv/DescribeParameters": (
        "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff"
    ),
    "rcl_interfaces/srv/ListParameters": (
        "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d"
    ),
    "rcl_interfaces/srv/GetLoggerLevels": (
        "03bf1bebd0d6514c7ed0ba7c5e08dc9f2f39c759fe99e1e30ea4157d7674f72d"
    ),
    "rcl_interfaces/srv/SetLoggerLevels": (
        "3ff86cb4e91fbf9abae15c234ecc874448de6ece8e193401c077cf116e4f6d78"
    ),
    "type_description_interfaces/srv/GetTypeDescription": (
        "69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5"
    ),
    "action_msgs/srv/CancelGoal": (
        "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"
    ),
    "std_srvs/srv/Empty": "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
    "std_srvs/srv/SetBool": "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    "example_interfaces/srv/AddTwoInts": (
        "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
    ),
    "sensor_msgs/srv/SetCameraInfo": (
        "a10cca5d33dc637c8d49db50ab288701a3592bb9cd854f2f16a0659613b68984"
    ),
    "lifecycle_msgs/srv/ChangeState": (
        "356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5"
    ),
    "lifecycle_msgs/srv/GetState": (
        "800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795"
    ),
    "example_interfaces/action/Fibonacci_SendGoal": (
        "d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557"
    ),
    "example_interfaces/action/Fibonacci_GetResult": (
        "1b0de0d5d29dc955d92f546706568428632771db13ec84c15ec1c1a59f424a57"
    ),
    "example_interfaces/action/Fibonacci_FeedbackMessage": (
        "c1de71afd52e49a89c53d8262366884185bc0a02f78ce051c4e46b0a7fe59bb2"
    ),
    "example_interfaces/action/Fibonacci": (
        "9508051da1ea4658de144b09bd0690ff3de52104683d847aed764d2915906f51"
    ),
    "composition_interfaces/srv/LoadNode": (
        "2e521ef6066fba6d7fc3a3b175d486709f01b4d738d9a59188858546fc8e5acd"
    ),
}


@pytest.mark.parametrize("type_name", HASHES)
def test_hashes_are_those_of_ros(type_name):
    assert store.type_hash(type_name) == f"RIHS01_{HASHES[type_name]}"


@pytest.mark.parametrize(
    ("kind", "type_id"),
    [
        (FieldType("char"), 3),
        (FieldType("string", string_capacity=5), 21),
        (FieldType("wstring", string_capacity=5), 22),
        (FieldType("uint8", Shape.ARRAY, 16), 3 + 48),
        (FieldType("float64", Shape.BOUNDED, 2), 11 + 96),
        (FieldType("a/msg/B", Shape.UNBOUNDED), 1 + 144),
    ],
)
def test_type_numbers(kind, type_id):
    assert hashing.field_type_id(Field("x", kind)) == type_id


def test_known_types_can_be_hashed():
    hashes = [store.type_hash(name) for name in sample(store.list_types(), 5)]
    assert len(hashes) > 250
    assert len(set(hashes)) == len(hashes)


def no_other(type_name: str) -> Definition:
    raise AssertionError(f"{type_name} is asked for")


def test_defaults_and_constants_do_not_change_a_hash():
    plain = Definition("a/msg/B", (Field("x", FieldType("int8")),))
    with_default = Definition("a/msg/B", (Field("x", FieldType("int8"), 5),))
    # They name no other types.
    assert hashing.type_hash(plain, no_other) == hashing.type_hash(with_default, no_other)


def test_the_description_lists_referenced_types_once_and_sorted():
    description = store.type_description("geometry_msgs/msg/TransformStamped")
    referenced = [t["type_name"] for t in description["referenced_type_descriptions"]]
    assert referenced == [
        "builtin_interfaces/msg/Time",
        "geometry_msgs/msg/Quaternion",
        "geometry_msgs/msg/Transform",
        "geometry_msgs/msg/Vector3",
        "std_msgs/msg/Header",
    ]


def test_an_unknown_type_has_no_hash():
    with pytest.raises(TeleopctlError, match="Unknown interface type"):
        store.type_hash("std_msgs/msg/Strin")
