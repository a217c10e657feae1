import pytest
from hypothesis import given, strategies as st

from teleopctl.wire.qos import EndpointQos
from teleopctl.wire.tokens import (
    EndpointToken,
    EntityKind,
    NodeToken,
    format_token,
    gid,
    parse_token,
)
from tests.wire.test_keys import NAME, NAME_PART, STRING_HASH, TYPE_HASH, TYPE_NAME
from tests.wire.test_qos import ENDPOINT_QOS

ZID = "aac3178e146ba6f1fc6e6a4085e77f21"
NODE_TEXT = f"@ros2_lv/0/{ZID}/0/0/NN/%/%/talker"
PUBLISHER_TEXT = (
    f"@ros2_lv/0/{ZID}/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/"
    f"{STRING_HASH}/::,7:,:,:,,"
)
SUBSCRIPTION_TEXT = (
    f"@ros2_lv/0/{ZID}/0/11/MS/%/%ns%sub/listener/%ns%sub%chatter/"
    f"std_msgs::msg::dds_::String_/{STRING_HASH}/::,10:,:,:,,"
)

NODE = NodeToken(0, ZID, 0, "/", "/", "talker")
PUBLISHER = EndpointToken(
    0, ZID, 0, 10, EntityKind.MP, "/", "/", "talker", "/chatter", "std_msgs/msg/String",
    STRING_HASH, EndpointQos(depth=7),
)  # fmt: skip
SUBSCRIPTION = EndpointToken(
    0, ZID, 0, 11, EntityKind.MS, "/", "/ns/sub", "listener", "/ns/sub/chatter",
    "std_msgs/msg/String", STRING_HASH, EndpointQos(depth=10),
)  # fmt: skip

ID = st.integers(0, 2**31)
NAMESPACE = st.just("/") | NAME
NODE_TOKENS = st.builds(
    NodeToken,
    domain=st.integers(0, 232),
    zid=st.from_regex(r"[1-9a-f][0-9a-f]{0,31}", fullmatch=True),
    nid=ID,
    enclave=NAMESPACE,
    namespace=NAMESPACE,
    node=NAME_PART,
    text=st.just(""),
)
ENDPOINT_TOKENS = st.builds(
    EndpointToken,
    domain=st.integers(0, 232),
    zid=st.from_regex(r"[1-9a-f][0-9a-f]{0,31}", fullmatch=True),
    nid=ID,
    eid=ID,
    kind=st.sampled_from([EntityKind.MP, EntityKind.MS, EntityKind.SS, EntityKind.SC]),
    enclave=NAMESPACE,
    namespace=NAMESPACE,
    node=NAME_PART,
    name=NAME,
    type_name=TYPE_NAME,
    type_hash=TYPE_HASH | st.just("TypeHashNotSupported"),
    qos=ENDPOINT_QOS,
    backends=st.none() | st.sampled_from(["cpu:", "cpu:;cuda:0%3A1"]),
    text=st.just(""),
)
VECTORS = [
    (NODE_TEXT, NODE),
    (PUBLISHER_TEXT, PUBLISHER),
    (SUBSCRIPTION_TEXT, SUBSCRIPTION),
]


@pytest.mark.parametrize(("text", "token"), VECTORS)
def test_known_tokens_are_written_and_read(text, token):
    assert format_token(token) == text
    assert parse_token(text) == token._replace(text=text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (NODE_TEXT, "34e0f0eaf0a5e0c897d90e747bb8850d"),
        (PUBLISHER_TEXT, "c128aa5567af01b7163eae5e2a8362d7"),
        (SUBSCRIPTION_TEXT, "f7826ad123ae9c5998d084971c5c1632"),
        ("", "7f498d4624c30160d8984701d306aa99"),
    ],
)
def test_the_gid_is_that_of_rmw_zenoh(text, expected):
    assert gid(text).hex() == expected


def test_the_gid_of_a_received_token_is_that_of_its_text_as_received():
    # Other implementations leave the depth out where we write it.
    text = PUBLISHER_TEXT.replace(",7:", ",:")
    token = parse_token(text)
    assert isinstance(token, EndpointToken)
    assert token.qos.depth == 42
    assert token.gid == gid(text) != gid(format_token(token))
    assert PUBLISHER.gid.hex() == "c128aa5567af01b7163eae5e2a8362d7"


@given(NODE_TOKENS | ENDPOINT_TOKENS)
def test_every_token_survives_the_wire(token):
    text = format_token(token)
    assert parse_token(text) == token._replace(text=text)


def test_the_backends_of_lyrical_are_read_and_written():
    text = f"{PUBLISHER_TEXT}/backends:cpu:"
    token = parse_token(text)
    assert isinstance(token, EndpointToken)
    assert token.backends == "cpu:"
    assert format_token(PUBLISHER._replace(backends="cpu:")) == text


def test_full_names_join_namespace_and_node():
    assert NODE.full_name == "/talker"
    assert SUBSCRIPTION.full_name == "/ns/sub/listener"


@given(st.text() | st.lists(st.text(max_size=6), max_size=16).map("/".join))
def test_garbage_is_no_token(text):
    assert parse_token(text) is None


@given(
    st.sampled_from([NODE_TEXT, PUBLISHER_TEXT, SUBSCRIPTION_TEXT]),
    st.integers(0, 12),
    st.text(max_size=8),
)
def test_a_token_with_any_chunk_replaced_never_raises(text, index, chunk):
    chunks = text.split("/")
    chunks[index % len(chunks)] = chunk
    token = parse_token("/".join(chunks))
    assert token is None or isinstance(token, NodeToken | EndpointToken)


@pytest.mark.parametrize(
    "text",
    [
        NODE_TEXT.removesuffix("/talker"),
        NODE_TEXT.replace("/%/%/", "//%/"),
        NODE_TEXT.replace("@ros2_lv", "ros2_lv"),
        NODE_TEXT.replace("/NN/", "/XX/"),
        NODE_TEXT.replace("/0/0/", "/0/-1/"),
        PUBLISHER_TEXT.rpartition("/")[0],
        PUBLISHER_TEXT.replace("::,7:,:,:,,", "nonsense"),
        NODE_TEXT + "x" * 10_000,
    ],
)
def test_a_text_of_another_form_is_no_token(text):
    assert parse_token(text) is None


@pytest.mark.parametrize("node", ["", "a/b", "a*", "a#b", "a?", "$*"])
def test_a_name_that_would_break_the_token_is_refused(node):
    with pytest.raises(ValueError, match="liveliness token"):
        format_token(NODE._replace(node=node))
