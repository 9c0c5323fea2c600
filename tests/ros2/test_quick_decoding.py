"""The extra `fast`, which rosbase-ros2 brings: JSON is read quickly, and just as by Python."""

import json
import math
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosbase.mapping import decoding
from rosbase.mapping.decoding import decode_payload

NUMBERS = st.integers() | st.floats() | st.sampled_from([2**63, -(2**63) - 1, 2**64, 10**400])
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)
LINES = st.builds(lambda value: json.dumps(value).encode(), VALUES)


def alike(one: Any, other: Any) -> bool:
    """Equal with the same types, and NaN is NaN."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return list(one) == list(other) and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(alike, one, other))
    return bool(one == other) or (isinstance(one, float) and math.isnan(one) and math.isnan(other))


def carefully(frame: bytes) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(decoding, "_decode_quickly", None)
        return decode_payload(frame)


def test_the_extra_is_installed_with_rosbase_ros2() -> None:
    assert decoding._decode_quickly is not None


@given(LINES)
@example(b'{"a":1,"a":2}')
@example(b'{"a":NaN,"b":[1e999,-Infinity]}')
@example(b'["\\ud800"]')
@example(b'\xef\xbb\xbf{"a":1}')
@example(b"[-0,-0.0,1e5,1E-400,9007199254740993]")
@example(b"[" * 5000)
@example(b"[" + b"9" * 5000 + b"]")
def test_json_is_read_as_without_it(frame: bytes) -> None:
    assert alike(decode_payload(frame), carefully(frame))


@given(st.binary(), LINES, st.data())
def test_damaged_json_is_refused_as_without_it(junk: bytes, line: bytes, data: Any) -> None:
    at = data.draw(st.integers(0, len(line)))
    for frame in (junk, line[:at], line[at:], line[:at] + junk + line[at:]):
        assert alike(decode_payload(frame), carefully(frame))
