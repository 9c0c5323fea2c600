"""Checksums of lines: what a line lost, or got from another, does not pass."""

import json
import zlib
from random import Random

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosbase.errors import ParameterError
from rosbase.imu.checks.checksum import CHECKSUMS, compile_checksum
from rosbase.mapping.rejects import Reject
from support.strategies import good_payloads

CRCS = [kind for kind in CHECKSUMS if kind.startswith("crc")]


def signed(content: bytes, kind: str, separator: str = "*") -> bytes:
    compute, digits = CHECKSUMS[kind]
    return content + f"{separator}{compute(content):0{digits}X}".encode()


def reason(found: bytes | Reject) -> str:
    assert isinstance(found, Reject), found
    return found.reason


@pytest.mark.parametrize(
    ("kind", "of_the_digits"),
    [
        # The check values of the catalogue of CRCs, which are those of "123456789".
        ("crc16_modbus", 0x4B37),
        ("crc16_ccitt", 0x29B1),
        ("crc16_xmodem", 0x31C3),
        ("crc32", 0xCBF43926),
        ("xor", 0x31),
    ],
)
def test_each_checksum_is_the_one_of_that_name(kind: str, of_the_digits: int) -> None:
    compute, _ = CHECKSUMS[kind]
    assert compute(b"123456789") == of_the_digits


def test_a_sentence_of_nmea_passes() -> None:
    # From the standard's own example; the dollar is not covered.
    verify = compile_checksum("xor")
    sentence = b"GPGLL,5300.97914,N,00259.98174,E,125926,A"
    assert verify(b"$" + sentence + b"*28\r") == sentence


def line(number: int) -> bytes:
    draw = Random(number)
    payload = {
        name: [round(draw.gauss(0, 2), 3) for _ in range(3)] for name in ("acc", "gyr", "mag")
    }
    return json.dumps({"n": number, **payload}, separators=(",", ":")).encode()


@given(good_payloads(), st.sampled_from(sorted(CHECKSUMS)), st.sampled_from(["*", "#", " crc="]))
def test_what_was_signed_comes_back_as_it_was(payload: object, kind: str, separator: str) -> None:
    content = json.dumps(payload).encode()
    verify = compile_checksum(kind, separator)
    assert verify(signed(content, kind, separator)) == content
    assert verify(signed(content, kind, separator).lower().replace(content.lower(), content))


@given(
    st.integers(0, 50),
    st.sampled_from(sorted(CHECKSUMS)),
    st.integers(0, 10**6),
    st.integers(1, 255),
)
def test_any_byte_that_changes_is_caught(number: int, kind: str, place: int, change: int) -> None:
    content = line(number)
    whole = bytearray(signed(content, kind))
    place %= len(whole)
    whole[place] ^= change
    found = compile_checksum(kind)(bytes(whole))
    if place > len(content) and bytes(whole).upper() == signed(content, kind):
        assert found == content, "a digit in lower case is the same digit"
    else:
        assert reason(found) in ("bad_checksum", "no_checksum")


@given(st.integers(0, 50), st.integers(51, 100), st.integers(0, 200), st.integers(0, 200))
def test_a_splice_of_two_lines_is_caught(first: int, second: int, head: int, tail: int) -> None:
    one, other = signed(line(first), "crc32"), signed(line(second), "crc32")
    spliced = one[: head % len(one)] + other[tail % len(other) :]
    assume(spliced not in (one, other))
    assert reason(compile_checksum("crc32")(spliced)) in ("bad_checksum", "no_checksum")


@pytest.mark.parametrize(("kind", "most"), [("xor", 90), ("crc16_modbus", 1), ("crc16_ccitt", 1)])
def test_of_three_thousand_splices_that_are_json_only_chance_lets_any_pass(
    kind: str, most: int
) -> None:
    draw, verify, passed, spliced = Random(1), compile_checksum(kind), 0, 0
    while spliced < 3000:
        one, other = line(draw.randrange(1000)), line(draw.randrange(1000))
        mixed = one[: one.index(b'"gyr"')] + other[other.index(b'"gyr"') :]
        if mixed not in (one, other):
            assert json.loads(mixed)
            spliced += 1
            passed += isinstance(verify(mixed + signed(other, kind)[len(other) :]), bytes)
    # Texts of digits have few different sums; a CRC has 65,536.
    assert passed <= most


@pytest.mark.parametrize(
    ("frame", "due"),
    [
        (b'{"acc":[0,0,9.8]}', "no_checksum"),
        (b"ets Jul 29 2019 12:21:46", "no_checksum"),
        (b'{"name":"a*b","acc":[0,0,9.8]}', "no_checksum"),
        (b"", "no_checksum"),
        (b'{"acc":[0,0,9.8]}*', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*5', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*ZZ', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*0x5A', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*5A5A', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*\xff\xff', "bad_checksum"),
        (b'{"acc":[0,0,9.8]}*+5', "bad_checksum"),
        (b"*00", ""),
    ],
)
def test_a_line_without_a_checksum_is_told_from_one_with_a_bad_one(frame: bytes, due: str) -> None:
    found = compile_checksum("xor")(frame)
    assert (found.reason if isinstance(found, Reject) else "") == due


def test_the_checksum_of_zlib_is_the_one_that_firmware_has_at_hand() -> None:
    content = line(1)
    frame = content + b"*" + f"{zlib.crc32(content):08x}".encode()
    assert compile_checksum("crc32")(frame) == content


@given(st.binary(max_size=60), st.sampled_from(sorted(CHECKSUMS)))
def test_no_bytes_make_it_raise(frame: bytes, kind: str) -> None:
    compile_checksum(kind)(frame)


@pytest.mark.parametrize("separator", ["", " ", "A", " 0", "\t"])
def test_a_separator_that_may_be_a_digit_or_nothing_is_refused(separator: str) -> None:
    with pytest.raises(ParameterError, match="checksum_separator"):
        compile_checksum("xor", separator)
