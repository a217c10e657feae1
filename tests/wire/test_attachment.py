import pytest
from hypothesis import given, strategies as st

from teleopctl.wire.attachment import Attachment, decode_attachment, encode_attachment, is_legacy

INT64 = st.integers(-(2**63), 2**63 - 1)
GID = st.binary(min_size=16, max_size=16)


def test_a_known_attachment_is_written_and_read():
    data = bytes.fromhex("010000000000000015cd853dfe9c971710000102030405060708090a0b0c0d0e0f")
    assert encode_attachment(1, 1_700_000_000_123_456_789, bytes(range(16))) == data
    assert decode_attachment(data) == Attachment(1, 1_700_000_000_123_456_789, bytes(range(16)))


def test_a_recorded_attachment_of_another_implementation_is_read():
    data = bytes.fromhex("000000000000000000a142ba97f5e91810f372386a51774d4b91318de61ee007cc")
    assert decode_attachment(data) == Attachment(
        0, 1_795_235_958_497_648_896, bytes.fromhex("f372386a51774d4b91318de61ee007cc")
    )


def test_it_equals_the_serialisation_of_zenoh():
    from zenoh.ext import Int64, z_serialize

    gid = bytes(range(16))
    theirs = z_serialize((Int64(7), Int64(9), gid))
    assert encode_attachment(7, 9, gid) == theirs.to_bytes()


@given(INT64, INT64, GID)
def test_every_attachment_survives_the_wire(sequence, time_ns, gid):
    assert decode_attachment(encode_attachment(sequence, time_ns, gid)) == Attachment(
        sequence, time_ns, gid
    )


@given(st.binary(max_size=100))
def test_garbage_is_no_attachment_or_one_that_is_written_alike(data):
    attachment = decode_attachment(data)
    assert attachment is None or encode_attachment(*attachment) == data


def test_a_wrong_length_byte_is_no_attachment():
    assert decode_attachment(bytes(16) + b"\x0f" + bytes(16)) is None


@pytest.mark.parametrize("size", [0, 15, 17, 24])
def test_a_gid_of_another_size_is_refused(size):
    with pytest.raises(ValueError, match="16 bytes"):
        encode_attachment(1, 2, bytes(size))


def test_the_attachment_of_an_old_rmw_zenoh_is_recognised():
    old = (
        b"\x0fsequence_number" + bytes(8) + b"\x10source_timestamp" + bytes(8)
        + b"\x0asource_gid" + b"\x10" + bytes(16)
    )  # fmt: skip
    assert decode_attachment(old) is None
    assert is_legacy(old)
    assert not is_legacy(encode_attachment(1, 2, bytes(16)))
