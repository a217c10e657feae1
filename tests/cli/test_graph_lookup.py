"""Names with ``*``."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.cli.graph_lookup import expand_patterns, matching_names
from teleopctl.errors import NotFoundError

NAMES = ["/arm/left/joint", "/arm/right", "/arm/right.x", "/base", "/a[b]"]


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("/arm/*", ["/arm/right", "/arm/right.x"]),
        ("arm/**", ["/arm/left/joint", "/arm/right", "/arm/right.x"]),
        ("**/joint", ["/arm/left/joint"]),
        ("/b*e", ["/base"]),
        ("/*", ["/base", "/a[b]"]),
        ("/a[b]*", ["/a[b]"]),
        ("/arm/*ight", ["/arm/right"]),
    ],
)
def test_one_star_is_a_part_of_a_name_and_two_are_any_number(pattern, found):
    assert matching_names(pattern, NAMES, kind="topic") == found


def test_a_pattern_that_nothing_fits_is_told():
    with pytest.raises(NotFoundError, match=r"No node fits '/x/\*'"):
        expand_patterns(["/base", "/x/*"], NAMES, kind="node")


@given(st.lists(st.sampled_from([*NAMES, "/new", "base", "/arm/*", "/**"]), max_size=6))
def test_each_name_is_meant_once_in_the_order_of_the_words(words):
    found = expand_patterns(words, NAMES, kind="topic")
    assert len(found) == len(set(found))
    alone = [expand_patterns([word], NAMES, kind="topic") for word in words]
    assert set(found) == {name for names in alone for name in names}
    assert found[:1] == (alone[0][:1] if alone else [])
