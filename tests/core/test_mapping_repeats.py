"""An object with a key twice is no valid sample, wherever it is and however it is written."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.mapping import repeats
from rosbase.mapping.decoding import decode_payload
from rosbase.mapping.rejects import Reject

KEYS = st.sampled_from(["a", "b", "a1", "a2", "e", "E", "", "-", "k:", '"', "\\", "é", "\n"])
VALUES = st.sampled_from(["1", "-1.5e3", "NaN", "true", '"12:30:00"', '"a\\":1"', "[]", "{}"])
Pairs = list[tuple[str, Any]]
TREES = st.recursive(
    VALUES,
    lambda inner: st.lists(st.tuples(KEYS, inner), max_size=4) | st.lists(inner, max_size=3),
    max_leaves=12,
)


def is_object(tree: Any) -> bool:
    return isinstance(tree, list) and all(isinstance(item, tuple) for item in tree)


def write(tree: Any, space: str, data: st.DataObject) -> str:
    """The tree as JSON: lists of pairs are objects."""
    if isinstance(tree, str):
        return tree
    if is_object(tree):
        members = [f"{key(k, data)}{space}:{space}{write(v, space, data)}" for k, v in tree]
        return f"{{{','.join(members)}}}"
    return f"[{','.join(write(item, space, data) for item in tree)}]"


def key(text: str, data: st.DataObject) -> str:
    escaped = "".join(f"\\u{ord(letter):04x}" for letter in text)
    return f'"{escaped}"' if data.draw(st.booleans()) else json.dumps(text)


def has_repeats(tree: Any) -> bool:
    if isinstance(tree, str):
        return False
    if is_object(tree):
        keys = [k for k, _ in tree]
        return len(set(keys)) < len(keys) or any(has_repeats(v) for _, v in tree)
    return any(has_repeats(item) for item in tree)


@given(st.lists(st.tuples(KEYS, TREES), max_size=5), st.sampled_from(["", " ", "\t"]), st.data())
def test_a_key_that_stands_twice_anywhere_is_bad_json(
    tree: Pairs, space: str, data: st.DataObject
) -> None:
    frame = write(tree, space, data).encode()
    for _ in range(2):
        # The second time its form may be known.
        found = decode_payload(frame)
        if has_repeats(tree):
            assert isinstance(found, Reject)
            assert found.reason == "bad_json"
            assert "stands twice" in found.detail
        else:
            assert isinstance(found, dict)


@pytest.mark.parametrize(
    "frame",
    [
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"acc":[0,0,3.1]}',
        b'{"imu":{"ax":1,"ay":2,"az":9,"ax":3},"t":5}',
        b'{"log":[{"level":1,"level":2}],"acc":[0,0,9.8]}',
        b'{"x" :1,"y" : 2,"\\u0078":3}',
        b'{"stamp":"12:30:01","stamp":"12:30:02"}',
    ],
)
def test_the_key_is_named_also_where_nobody_reads_it(frame: bytes) -> None:
    found = decode_payload(frame)
    assert isinstance(found, Reject)
    assert found.reason == "bad_json"
    assert "stands twice" in found.detail


def test_a_form_that_was_seen_does_not_hide_keys_that_differ_in_digits() -> None:
    for number in range(10):
        assert isinstance(decode_payload(b'{"a1":%d,"a2":%d}' % (number, number)), dict)
    assert isinstance(decode_payload(b'{"a1":1,"a1":2}'), Reject)


def test_forms_that_are_remembered_are_limited() -> None:
    for number in range(500):
        letters = "".join(chr(97 + int(digit)) for digit in str(number))
        decode_payload(json.dumps({letters: 1, "text": "x" * 5_000 * (number % 2)}).encode())
    assert len(repeats.known_forms) <= 64
    assert max(map(len, repeats.known_forms)) <= 4096
