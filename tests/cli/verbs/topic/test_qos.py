"""The QoS that ``topic echo`` and ``topic pub`` use."""

import pytest

from teleopctl.cli.verbs.topic.endpoints import qos_lines, qos_record
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.node.generic_subscription import qos_for_publishers
from teleopctl.node.values.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from teleopctl.wire.qos import EndpointQos

RELIABLE, BEST_EFFORT = EndpointQos(), EndpointQos(reliability=2)
LATCHED = EndpointQos(durability=1)


@pytest.mark.parametrize(
    ("offers", "reliability", "durability"),
    [
        ([], ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE),
        ([RELIABLE], ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE),
        ([BEST_EFFORT, RELIABLE], ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE),
        ([LATCHED], ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL),
        ([LATCHED, RELIABLE], ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE),
    ],
)
def test_it_follows_what_the_publishers_offer(offers, reliability, durability):
    qos = qos_for_publishers(offers, 10)
    assert (qos.reliability, qos.durability, qos.depth) == (reliability, durability, 10)


def test_what_a_person_asks_for_wins():
    base = QoSProfile(depth=10)
    options = QosOptions(
        qos_reliability="best_effort",
        qos_durability="transient_local",
        qos_history="keep_all",
        qos_depth=3,
    )
    qos = options.applied_to(base)
    assert qos.reliability == ReliabilityPolicy.BEST_EFFORT
    assert qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert qos.history == HistoryPolicy.KEEP_ALL
    assert qos.depth == 3
    assert base == QoSProfile(depth=10)


def test_a_preset_replaces_the_base_and_stays_as_it_is():
    qos = QosOptions(qos_profile="sensor_data", qos_depth=7).applied_to(QoSProfile(depth=10))
    assert (qos.reliability, qos.depth) == (ReliabilityPolicy.BEST_EFFORT, 7)
    again = QosOptions(qos_profile="sensor_data").applied_to(QoSProfile(depth=10))
    assert again.depth == 5


def test_a_preset_alone_gives_way_to_what_the_publishers_offer_as_in_ros2():
    offered = QoSProfile(
        depth=10,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )
    alone = QosOptions(qos_profile="default").for_subscription(offered)
    assert (alone.reliability, alone.durability) == (offered.reliability, offered.durability)
    beside = QosOptions(qos_profile="default", qos_depth=3).for_subscription(offered)
    assert beside.reliability == ReliabilityPolicy.RELIABLE
    single = QosOptions(qos_reliability="reliable").for_subscription(offered)
    assert (single.reliability, single.durability) == (
        ReliabilityPolicy.RELIABLE,
        DurabilityPolicy.TRANSIENT_LOCAL,
    )


def test_qos_text_is_that_of_ros2():
    assert qos_lines(EndpointQos(depth=10)) == [
        "QoS profile:",
        "  Reliability: RELIABLE",
        "  History (Depth): KEEP_LAST (10)",
        "  Durability: VOLATILE",
        "  Lifespan: Infinite",
        "  Deadline: Infinite",
        "  Liveliness: AUTOMATIC",
        "  Liveliness lease duration: Infinite",
    ]
    odd = EndpointQos(2, 1, 2, 5, 100_000_000, liveliness=3)
    assert qos_lines(odd)[1:6] == [
        "  Reliability: BEST_EFFORT",
        "  History (Depth): KEEP_ALL",
        "  Durability: TRANSIENT_LOCAL",
        "  Lifespan: Infinite",
        "  Deadline: 100000000 nanoseconds",
    ]


def test_qos_record_has_null_for_what_never_ends():
    record = qos_record(EndpointQos(deadline_ns=5))
    assert (record["deadline_ns"], record["lifespan_ns"]) == (5, None)
    assert record["reliability"] == "reliable"
