"""Policies of quality of service."""

import pytest

from teleopctl.node import DurabilityPolicy


def test_a_policy_is_known_by_its_name_in_rmw_with_a_warning():
    old_name = "RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL"
    with pytest.warns(UserWarning, match=r"Use DurabilityPolicy.TRANSIENT_LOCAL instead"):
        assert getattr(DurabilityPolicy, old_name) is DurabilityPolicy.TRANSIENT_LOCAL
    for unknown in ("RMW_QOS_POLICY_HISTORY_VOLATILE", "RMW_QOS_POLICY_DURABILITY_NONE", "NONE"):
        assert not hasattr(DurabilityPolicy, unknown)
