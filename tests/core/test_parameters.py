import array
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import ParameterError
from rosbase.parameters import (
    ParameterKind,
    ParameterSpec,
    WrittenText,
    check_value,
    from_outside,
    parse_text,
    parse_written,
)
from support.strategies import yaml_scalars

BAUD = ParameterSpec("baudrate", 115_200, minimum=1, maximum=20_000_000)
TIMEOUT = ParameterSpec("timeout", 1.0, minimum=0.0)
FLAG = ParameterSpec("flag", default=False)
NAME = ParameterSpec("name", "imu_link")
MODE = ParameterSpec("mode", "warn", choices=("warn", "off"))
STDDEV = ParameterSpec("stddev", [], kind=ParameterKind.DOUBLE_ARRAY, minimum=0.0)
PATHS = ParameterSpec("paths", [], kind=ParameterKind.STRING_ARRAY)
VERSION = ParameterSpec("version", "3.1.1", choices=("3.1.1", "5"))
SWITCH = ParameterSpec("dtr", "leave", choices=("leave", "on", "off"))
COUNTS = ParameterSpec("counts", [], kind=ParameterKind.INTEGER_ARRAY)
FLAGS = ParameterSpec("flags", [], kind=ParameterKind.BOOL_ARRAY)
KEY = ParameterSpec("key", [], kind=ParameterKind.BYTE_ARRAY)
KINDS = [BAUD, TIMEOUT, FLAG, NAME, MODE, STDDEV, PATHS, COUNTS, FLAGS, KEY]


@pytest.mark.parametrize(
    ("spec", "text", "value"),
    [
        (BAUD, "921600", 921_600),
        (TIMEOUT, "2", 2.0),
        (TIMEOUT, "2.5e-1", 0.25),
        (FLAG, "true", True),
        (FLAG, "off", False),
        (FLAG, "Y", True),
        (BAUD, "0x10", 16),
        (TIMEOUT, "00.5", 0.5),
        (NAME, "no", "no"),
        (NAME, "0042", "0042"),
        (SWITCH, "off", "off"),
        (VERSION, "5", "5"),
        (PATHS, "[x, y, no, 1]", ["x", "y", "no", "1"]),
        (COUNTS, "[1, 0x10]", [1, 16]),
        (COUNTS, "7", [7]),
        (FLAGS, "[on, false]", [True, False]),
        (KEY, "[0, 255]", [b"\x00", b"\xff"]),
        (KEY, "[]", []),
        (NAME, "42", "42"),
        (NAME, "true", "true"),
        (MODE, "off", "off"),
        (STDDEV, "0.1", [0.1]),
        (STDDEV, "[0.1, 2, 3]", [0.1, 2.0, 3.0]),
        (PATHS, "[ax, 'ay', \"az\"]", ["ax", "ay", "az"]),
        (PATHS, "ax", ["ax"]),
        (PATHS, "[]", []),
        (PATHS, "[0].x, [1].x", ["[0].x", "[1].x"]),
        (PATHS, "[[0].x, [1].x]", ["[0].x", "[1].x"]),
        (PATHS, "[kind=acc].x", ["[kind=acc].x"]),
        (PATHS, "[[*]]", ["[*]"]),
        (PATHS, "s[id=a,b].x,s[id=a,b].y", ["s[id=a,b].x", "s[id=a,b].y"]),
        (PATHS, """['"a.x"', '"a,y"', 'a."b c"']""", ['"a.x"', '"a,y"', 'a."b c"']),
        (PATHS, '"a"."b"', ['"a"."b"']),
        (PATHS, "T=it's, U=2", ["T=it's", "U=2"]),
    ],
)
def test_text_becomes_a_value_of_the_parameter(
    spec: ParameterSpec, text: str, value: object
) -> None:
    parsed = parse_text(spec, text)
    assert parsed == value
    assert type(parsed) is type(value)


@pytest.mark.parametrize(
    ("spec", "text", "complaint"),
    [
        (PATHS, '["x]', "parameter paths: the list '[\"x]' has an open quote or bracket"),
        (PATHS, "[a, b", "parameter paths: the list '[a, b' has an open quote or bracket"),
        (PATHS, "['a, b]", "parameter paths: the list "),
        (STDDEV, "[1, 2", "parameter stddev: the list '[1, 2' has an open quote or bracket"),
        (BAUD, "fast", "parameter baudrate takes a whole number, not 'fast'"),
        (BAUD, "1.5", "parameter baudrate takes a whole number, not 1.5"),
        (BAUD, "true", "parameter baudrate takes a whole number, not True"),
        (BAUD, "0", "parameter baudrate is at least 1, not 0"),
        (BAUD, "9" * 5000, "parameter baudrate takes a whole number"),
        (BAUD, "9" * 300, "parameter baudrate is at most"),
        (BAUD, "9" * 390, "parameter baudrate is at most"),
        (TIMEOUT, "nan", "parameter timeout takes a number, not 'nan'"),
        (TIMEOUT, "1e999", "parameter timeout must be finite, not inf"),
        (TIMEOUT, "9" * 390, "parameter timeout is too large"),
        (FLAG, "1", "parameter flag takes true or false, not 1"),
        (BAUD, "0042", "parameter baudrate: 0042 is octal in YAML; write 42, if it is meant"),
        (TIMEOUT, "-007", "parameter timeout: -007 is octal in YAML; write -7, if it is meant"),
        (COUNTS, "[1, 02]", "parameter counts: 02 is octal in YAML; write 2, if it is meant"),
        (COUNTS, str(2**63), "parameter counts takes whole numbers of 64 bits"),
        (FLAGS, "[1]", "parameter flags takes booleans such as [true, false], not [1]"),
        (KEY, "[256]", "parameter key takes bytes such as [0, 255], not [256]"),
        (KEY, "abc", "parameter key takes bytes such as [0, 255], not ['abc']"),
        (MODE, "loud", "parameter mode is one of warn, off, not 'loud'"),
        (STDDEV, "[0.1, x]", "parameter stddev takes numbers"),
        (STDDEV, "-1", "parameter stddev is at least 0, not -1"),
        (NAME, "imu\0link", r"parameter name takes no NUL, as in 'imu\x00link'"),
        (PATHS, "ax, a\0y", r"parameter paths takes no NUL, as in ['ax', 'a\x00y']"),
    ],
)
def test_a_wrong_value_is_one_line_that_names_the_parameter(
    spec: ParameterSpec, text: str, complaint: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        parse_text(spec, text)
    assert str(caught.value).startswith(complaint)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200 or "at most" in complaint


@given(st.sampled_from(KINDS), st.text() | yaml_scalars)
def test_no_text_gets_past_as_anything_else(spec: ParameterSpec, text: str) -> None:
    try:
        value = parse_text(spec, text)
    except ParameterError:
        return
    assert check_value(spec, value) == value


def test_a_value_from_a_file_keeps_its_type() -> None:
    with pytest.raises(ParameterError, match="takes text, not 5"):
        check_value(NAME, 5)
    with pytest.raises(ParameterError, match="takes texts"):
        check_value(PATHS, [1, 2])


@pytest.mark.parametrize(
    ("default", "kind", "value"),
    [
        ([1.0, 2], ParameterKind.DOUBLE_ARRAY, [1.0, 2.0]),
        ((1, 2), ParameterKind.INTEGER_ARRAY, [1, 2]),
        ([True], ParameterKind.BOOL_ARRAY, [True]),
        (["a"], ParameterKind.STRING_ARRAY, ["a"]),
        ([b"a", b"b"], ParameterKind.BYTE_ARRAY, [b"a", b"b"]),
        (b"ab", ParameterKind.BYTE_ARRAY, [b"a", b"b"]),
        (array.array("d", [1.0]), ParameterKind.DOUBLE_ARRAY, [1.0]),
        (array.array("q", [1]), ParameterKind.INTEGER_ARRAY, [1]),
    ],
)
def test_a_default_says_which_array_it_is(default: Any, kind: ParameterKind, value: object) -> None:
    spec = ParameterSpec("gains", default)
    assert spec.kind is kind
    assert check_value(spec, spec.default) == value


@pytest.mark.parametrize("default", [[], (), [1, "a"], [True, 1], [[1.0]], array.array("d")])
def test_a_default_that_says_nothing_asks_for_the_kind(default: Any) -> None:
    if default == array.array("d"):
        # Its elements have a type of their own.
        assert ParameterSpec("gains", default).kind is ParameterKind.DOUBLE_ARRAY
        return
    with pytest.raises(TypeError, match="parameter gains: say which kind of array it is"):
        ParameterSpec("gains", default)
    spec = ParameterSpec("gains", [], kind=ParameterKind.DOUBLE_ARRAY)
    assert check_value(spec, spec.default) == []


@pytest.mark.parametrize(
    ("spec", "guessed", "value"),
    [
        (SWITCH, False, "off"),
        (SWITCH, True, "on"),
        (VERSION, 5, "5"),
        (TIMEOUT, 2, 2.0),
        (STDDEV, "[0, 2.5]", [0.0, 2.5]),
        (PATHS, "[x, no]", ["x", "no"]),
        (PATHS, "x", ["x"]),
    ],
)
def test_what_a_tool_has_guessed_is_taken_if_it_can_mean_but_one_thing(
    spec: ParameterSpec, guessed: object, value: object
) -> None:
    assert from_outside(spec, guessed) == value


@pytest.mark.parametrize(
    ("spec", "guessed"),
    [
        (NAME, False),
        (NAME, 34),
        (NAME, 1000.0),
        (SWITCH, 1),
        (VERSION, 3),
        (PATHS, [1, 2]),
        (ParameterSpec("both", "no", choices=("no", "off")), False),
    ],
)
def test_what_has_lost_its_text_is_refused_with_the_way_to_write_it(
    spec: ParameterSpec, guessed: object
) -> None:
    with pytest.raises(ParameterError, match="write text in quotes, in a shell as") as caught:
        from_outside(spec, guessed)
    assert str(caught.value).startswith(f"parameter {spec.name} takes text")


@pytest.mark.parametrize(
    ("spec", "written", "value"),
    [
        (NAME, WrittenText("5", is_quoted=True), "5"),
        (PATHS, WrittenText("x, y", is_quoted=True), ["x", "y"]),
        (PATHS, (WrittenText("a, b"), WrittenText("y", is_quoted=True)), ["a, b", "y"]),
        (KEY, WrittenText("AAE=", data=b"\0\1"), [b"\0", b"\1"]),
        (KEY, (WrittenText("AA==", data=b"\0"), WrittenText("7")), [b"\0", b"\7"]),
        (NAME, WrittenText("AA==", data=b"\0"), "AA=="),
    ],
)
def test_quotes_say_that_it_is_text(spec: ParameterSpec, written: Any, value: object) -> None:
    assert parse_written(spec, written) == value


@pytest.mark.parametrize(
    ("spec", "written"),
    [
        (BAUD, WrittenText("5", is_quoted=True)),
        (FLAG, WrittenText("true", is_quoted=True)),
        (STDDEV, (WrittenText("5", is_quoted=True),)),
        (NAME, (WrittenText("a"),)),
        (BAUD, ()),
    ],
)
def test_a_list_or_a_text_in_quotes_is_no_other_value(spec: ParameterSpec, written: Any) -> None:
    with pytest.raises(ParameterError, match=f"parameter {spec.name} takes"):
        parse_written(spec, written)
