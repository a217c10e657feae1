"""Which profiles of a publisher and a subscription fit each other."""

import copy
import pickle

import pytest

from teleopctl.node import (
    DurabilityPolicy,
    Duration,
    LivelinessPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_profile_sensor_data,
    qos_profile_system_default,
    qos_profile_unknown,
)

OK, WARNING, ERROR = QoSCompatibility
LATCHED = {"durability": DurabilityPolicy.TRANSIENT_LOCAL}
BEST_EFFORT = {"reliability": ReliabilityPolicy.BEST_EFFORT}
MANUAL = {"liveliness": LivelinessPolicy.MANUAL_BY_TOPIC}


@pytest.mark.parametrize(
    ("offered", "asked", "outcome"),
    [
        ({}, {}, OK),
        ({}, BEST_EFFORT, OK),
        (BEST_EFFORT, {}, ERROR),
        (LATCHED, {}, OK),
        ({}, LATCHED, ERROR),
        (MANUAL, {}, OK),
        ({}, MANUAL, ERROR),
        ({"deadline": Duration(seconds=1)}, {"deadline": Duration(seconds=2)}, OK),
        ({"deadline": Duration(seconds=2)}, {"deadline": Duration(seconds=1)}, ERROR),
        ({"deadline": Duration()}, {"deadline": Duration(seconds=1)}, ERROR),
        ({}, {"liveliness_lease_duration": Duration(seconds=1)}, ERROR),
    ],
)
def test_a_subscription_gets_what_it_asks_for_or_an_error(offered, asked, outcome):
    compatibility, reason = qos_check_compatible(
        QoSProfile(depth=1, **offered), QoSProfile(depth=1, **asked)
    )
    assert compatibility is outcome
    assert bool(reason) == (outcome is not OK)


@pytest.mark.parametrize("undecided", [qos_profile_system_default, qos_profile_unknown])
def test_what_is_left_to_the_system_is_a_warning_where_it_may_matter(undecided):
    reliable = QoSProfile(depth=1)
    assert qos_check_compatible(undecided, reliable)[0] is WARNING
    assert qos_check_compatible(qos_profile_sensor_data, undecided)[0] is WARNING


def test_a_profile_is_made_again_of_its_fields():
    profile = QoSProfile(depth=3, deadline=Duration(seconds=5))
    assert QoSProfile(**profile.get_c_qos_profile().to_dict()) == profile
    slots = {name.lstrip("_"): getattr(profile, name) for name in profile.__slots__}
    assert QoSProfile(**slots) == profile  # as ros2cli's daemon hands it over
    assert copy.deepcopy(profile) == pickle.loads(pickle.dumps(profile)) == profile
