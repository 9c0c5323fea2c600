"""YAML as `topic echo` writes it, and as values are typed.

`tests/ros2/test_yaml_oracle.py` compares what is written with PyYAML.
"""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.text.yaml_flow import read_flow
from rosbase.text.yaml_text import as_yaml
from support.strategies import YAML_KEYS, YAML_TEXTS


def test_invisible_characters_are_escaped() -> None:
    assert as_yaml({"a": "x\u202ey\x1b[2J"}) == 'a: "x\\u202Ey\\e[2J"\n'


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("data: hello world", {"data": "hello world"}),
        ("data: a, b", {"data": "a, b"}),
        ("{x: 1.0, y: -2}", {"x": "1.0", "y": "-2"}),
        (
            "{a: {b: [1, 2, 'x y'], c: \"q\\n\\u00e9\"}}",
            {"a": {"b": ["1", "2", "x y"], "c": "q\né"}},
        ),
        ('{"x": 1, "y": [true, null]}', {"x": "1", "y": ["true", None]}),
        ("{url: http://a:80/x#y}", {"url": "http://a:80/x#y"}),
        ("data: a  # a comment", {"data": "a"}),
        ("{a: 'it''s', b: it's}", {"a": "it's", "b": "it's"}),
        ("{a: -.inf, b: .NaN}", {"a": "-inf", "b": "nan"}),
        ("header: auto", {"header": "auto"}),
        ("{a: }", {"a": None}),
        ("[1, b c,]", ["1", "b c"]),
        ("", None),
        ("hello", "hello"),
    ],
)
def test_values_are_read_as_typed(text: str, value: Any) -> None:
    assert read_flow(text) == value


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{x: 1", "character 6: a comma or } must follow"),
        ("x: 1, y: 2", "a colon too many"),
        ("{a: 1} x", "'x' is too much"),
        ("{a: 1, a: 2}", "a is there twice"),
        ("{a}", "a colon and a value must follow a"),
        ('{a: "x}', "a quote is not closed"),
        ("[" * 100, "it is nested too deeply"),
    ],
)
def test_wrong_values_are_explained(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match="character") as caught:
        read_flow(text)
    assert reason in str(caught.value)


@given(st.text(st.sampled_from("ab:,{}[]'\"# \\\nx\u2028"), max_size=12))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        read_flow(text)
    except ValueError:
        pass


@given(
    st.dictionaries(
        YAML_KEYS,
        st.text(st.characters(codec="utf-8"), max_size=6) | st.lists(YAML_TEXTS, max_size=2),
    )
)
def test_what_echo_writes_in_one_line_can_be_typed(data: Any) -> None:
    assert read_flow(as_yaml(data, flow=True)) == data
