import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import ParameterError
from rosbase.parameters import ParameterKind, ParameterSpec, check_value, parse_text

BAUD = ParameterSpec("baudrate", 115_200, minimum=1, maximum=20_000_000)
TIMEOUT = ParameterSpec("timeout", 1.0, minimum=0.0)
FLAG = ParameterSpec("flag", default=False)
NAME = ParameterSpec("name", "imu_link")
MODE = ParameterSpec("mode", "warn", choices=("warn", "off"))
STDDEV = ParameterSpec("stddev", [], kind=ParameterKind.DOUBLE_ARRAY, minimum=0.0)
PATHS = ParameterSpec("paths", [], kind=ParameterKind.STRING_ARRAY)


@pytest.mark.parametrize(
    ("spec", "text", "value"),
    [
        (BAUD, "921600", 921_600),
        (TIMEOUT, "2", 2.0),
        (TIMEOUT, "2.5e-1", 0.25),
        (FLAG, "true", True),
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


@given(st.sampled_from([BAUD, TIMEOUT, FLAG, NAME, MODE, STDDEV, PATHS]), st.text())
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
