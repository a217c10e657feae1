import pytest
from hypothesis import given, strategies as st

from teleopctl.wire.qos import INFINITE_NS, EndpointQos, format_qos, parse_qos

MS = 1_000_000

VECTORS = [
    ("::,10:,:,:,,", EndpointQos(depth=10)),
    ("2::,5:,:,:,,", EndpointQos(reliability=2, depth=5)),
    ("::,1000:,:,:,,", EndpointQos(depth=1000)),
    (":1:,1000:,:10,0:,,", EndpointQos(durability=1, depth=1000, lifespan_ns=10_000 * MS)),
    (":1:,1:,:,:,,", EndpointQos(durability=1, depth=1)),
    ("2::,1:,:,:,,", EndpointQos(reliability=2, depth=1)),
    ("::2,10:,:,:,,", EndpointQos(history=2, depth=10)),
    ("::,10:0,100000000:,:,,", EndpointQos(depth=10, deadline_ns=100 * MS)),
    ("::,10:,:,:3,1,0", EndpointQos(depth=10, liveliness=3, lease_ns=1000 * MS)),
    (
        "4:4:,10:,854775806:,:5,,854775806",
        EndpointQos(
            reliability=4,
            durability=4,
            depth=10,
            deadline_ns=INFINITE_NS - 1,
            liveliness=5,
            lease_ns=INFINITE_NS - 1,
        ),
    ),
]

ENDPOINT_QOS = st.builds(
    EndpointQos,
    reliability=st.integers(1, 4),
    durability=st.integers(1, 4),
    history=st.integers(1, 3),
    depth=st.integers(1, 2**63),
    deadline_ns=st.integers(1, INFINITE_NS),
    lifespan_ns=st.integers(1, INFINITE_NS),
    liveliness=st.integers(1, 5),
    lease_ns=st.integers(1, INFINITE_NS),
)


@pytest.mark.parametrize(("text", "qos"), VECTORS)
def test_recorded_texts_are_written_and_read(text, qos):
    assert format_qos(qos) == text
    assert parse_qos(text) == qos


def test_an_empty_depth_is_read_as_42_but_never_written():
    assert parse_qos("::,:,:,:,,") == EndpointQos(depth=42)
    assert parse_qos("::2,:,:,:,,") == EndpointQos(history=2, depth=42)
    assert format_qos(EndpointQos(depth=42)) == "::,42:,:,:,,"


def test_what_is_left_to_the_system_becomes_the_default():
    unset = EndpointQos(0, 0, 0, 0, 0, 0, 0, 0)
    assert format_qos(unset) == "::,42:,:,:,,"


@given(ENDPOINT_QOS)
def test_every_qos_survives_the_wire(qos):
    assert parse_qos(format_qos(qos)) == qos


@pytest.mark.parametrize(
    "text",
    [
        "",
        "::,10:,:,:,",
        "::,10:,:,:,,:",
        "::10:,:,:,,",
        "5::,10:,:,:,,",
        ":5:,10:,:,:,,",
        "::4,10:,:,:,,",
        "::,10:,:,:6,,",
        "-1::,10:,:,:,,",
        " 1::,10:,:,:,,",
        "::,1_0:,:,:,,",
        "::,\u0661:,:,:,,",
        "::," + "9" * 5000 + ":,:,:,,",
    ],
)
def test_a_text_of_another_form_is_no_qos(text):
    assert parse_qos(text) is None


@given(st.text(alphabet=":,0123456789-x", max_size=60) | st.text())
def test_garbage_never_raises(text):
    qos = parse_qos(text)
    assert qos is None or isinstance(qos, EndpointQos)
