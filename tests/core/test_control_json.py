"""JSON as commands read and write it, beside Python's `json`."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.control import json_text
from rosbase.control.json_text import from_json, to_json

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)
PIECES = st.sampled_from(
    [*'{}[]",: \n\\0123456789.eE+-', "true", "false", "null", "NaN", "Infinity", "\\u00e9", "é"]
)


@pytest.fixture(params=["quick", "slow"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """By the C part, and as a Python without it does."""
    if request.param == "slow":
        monkeypatch.setattr(json_text, "_fast", None)
    return str(request.param)


def read(reader: Any, text: str) -> Any:
    """What it makes of a text; a class of errors for no JSON."""
    try:
        return repr(reader(text))
    except ValueError:
        return ValueError


@given(value=VALUES)
def test_it_is_written_as_json_writes_it(value: Any) -> None:
    assert to_json(value) == json.dumps(value, separators=(",", ":"))
    assert from_json(to_json(value)) == value


@given(
    text=st.lists(PIECES, max_size=12).map("".join)
    | VALUES.map(lambda value: json.dumps(value, indent=1))
)
def test_any_text_is_read_as_json_reads_it(text: str) -> None:
    def refuse(name: str) -> None:
        raise ValueError(name)

    assert read(from_json, text) == read(lambda t: json.loads(t, parse_constant=refuse), text)


def test_both_ways_are_one(way: str) -> None:
    assert to_json({"a": [1, None, "é"]}) == '{"a":[1,null,"\\u00e9"]}'
    assert from_json(' {"a": [1.5, true]} \n') == {"a": [1.5, True]}
    for wrong in (float("nan"), float("inf")):
        with pytest.raises(ValueError):  # noqa: PT011 - the texts differ
            to_json({"x": wrong})
    with pytest.raises(TypeError):
        to_json({"x": object()})
    for text in ("", "{", "1 2", "NaN", "[-Infinity]", "\ufeff1"):
        with pytest.raises(ValueError):  # noqa: PT011 - the texts differ
            from_json(text)
    with pytest.raises(RecursionError):
        from_json("[" * 100_000)


def test_a_loop_is_refused(way: str) -> None:
    loop: list[Any] = []
    loop.append(loop)
    with pytest.raises((ValueError, RecursionError)):
        to_json(loop)
