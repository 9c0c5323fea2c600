"""Paths and conditions as users write them: what they mean, and how they are refused."""

import re
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import MappingError
from rosbase.imu.mapping import ImuMapping
from rosbase.mapping.path_text import parse_condition, parse_path
from rosbase.mapping.paths import EACH, Condition, Way, Where, show_condition, show_steps
from support.mapping_cases import make_cases


def where(*conditions: tuple[str, Any]) -> Where:
    return Where(tuple(Condition(((key,),), value) for key, value in conditions))


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("accel.x", ("accel", "x")),
        ("data[0].x", ("data", 0, "x")),
        ("data.0.x", ("data", 0, "x")),
        ("007", ("007",)),
        ("[2][10]", (2, 10)),
        ('"accel.x"', ("accel.x",)),
        ('imu."to do"[0]."[1]"', ("imu", "to do", 0, "[1]")),
        (r'"say \"x\"".é', ('say "x"', "é")),
        ('"0"', ("0",)),
        ('""', ("",)),
        ("a-b_c°.µT", ("a-b_c°", "µT")),
        ('"a/b:c"."(x)"', ("a/b:c", "(x)")),
        ("$x", ("$x",)),
        ('"$".x."@"', ("$", "x", "@")),
        ("@timestamp", ("@timestamp",)),
        ("frames[*].a", ("frames", EACH, "a")),
        ("[*]", (EACH,)),
        ("s[id=acc].v", ("s", where(("id", "acc")), "v")),
        ("[type=101].v", (where(("type", 101)), "v")),
        ("s[ id = acc ][on=true].v", ("s", where(("id", "acc"), ("on", True)), "v")),
        ('s[id="a]b|c=d"]', ("s", where(("id", "a]b|c=d")))),
        ("s[id=007]", ("s", where(("id", "007")))),
        ("s[id=null]", ("s", where(("id", None)))),
        ("s[id=-1.5e1]", ("s", where(("id", -15.0)))),
    ],
)
def test_a_path_means_its_steps(text: str, steps: Any) -> None:
    assert parse_path(text) == (Way(steps),)
    assert parse_path(show_steps(steps)) == (Way(steps),)


def test_alternatives_and_minus_signs() -> None:
    assert parse_path("-new.z | old.z") == (Way(("new", "z"), -1.0), Way(("old", "z")))
    assert parse_path('"a|b"|[k="|"].c') == (Way(("a|b",)), Way((where(("k", "|")), "c")))


def test_conditions_compare_as_json_does() -> None:
    assert parse_condition("T=1") == parse_condition("T = 1.0")
    assert parse_condition("T=1") != parse_condition("T=true")
    assert parse_condition("T=1") != parse_condition('T="1"')
    unequal = parse_condition("meta.kind[0]|k!=status of x")
    assert unequal == Condition((("meta", "kind", 0), ("k",)), "status of x", is_equal=False)
    assert parse_condition(show_condition(unequal)) == unequal


REFUSED = {
    "": "it is empty",
    "$.acc.x": "leave out '$'",
    "@.acc": "leave out '@'",
    ".acc.x": "begins with a key, not with a dot",
    "a..b": "a key is missing",
    "a.": "a key is missing",
    "a.[0]": "a key is missing",
    "a|": "it is empty",
    "a|a": "alternatives are the same",
    "a[0": "a ] is missing",
    "a]": "']' is not expected",
    "a[": "in brackets stands",
    "a[]": "in brackets stands",
    "a[-1]": "an index counts from 0",
    "a[007]": "a key stands behind a dot: .007",
    'a["b"]': "a key stands behind a dot: .b",
    "a[b]": "a key stands behind a dot: .b",
    "a[0]b": "'b' is not expected",
    '"a': "a double quote is not closed",
    '"a"b': "'b' is not expected",
    "'a.b'": "in double quotes",
    "accel x": "in double quotes",
    "a,b": "in double quotes",
    "a.*": "every element of a list is written [*]",
    "a[*][*]": "[*] stands twice",
    "a[*].b[*]": "[*] stands twice",
    "--a": "a minus stands at the beginning",
    "a.-b": "a minus stands at the beginning",
    "a[b=]": "the value is missing",
    "a[b=c": "a ] is missing",
    "a[b=[1]]": "the value is missing",
    "a[b==1]": "the value is missing",
    "a[b>1]": "path=value or path!=value",
    "a[b!1]": "path=value or path!=value",
    "a[b[*]=1]": "keys and indices only",
    "a[b[c=1]=1]": "keys and indices only",
    "a[b=1][b=2]": "contradict each other",
    "a[b=1][b!=1]": "contradict each other",
    "a[b=1|2]": "a ] is missing, or a value is to be written in double quotes",
    "a[b=1e999]": "the number is too large",
    "T=1": "in double quotes",
    "/imu/acc": "'/' is not expected; write keys with other characters in double quotes",
    "#/imu/acc": "'#' is not expected",
    "acc(0)": "'(' is not expected at character 4; write keys with other characters in",
    "a;b;c": "';' is not expected",
    "a/1000": "'/' is not expected",
    "a*9.81": "'*' is not expected",
    "a+b": "'+' is not expected",
    "{a}": "'{' is not expected",
    "{{ a.x }}": "'{' is not expected",
    "${a}": "leave out '$'",
    "p.$.x": "leave out '$', or write it in double quotes if it is a key",
    "p.@.x": "leave out '@'",
    "$[0].x": "leave out '$'",
    "acc?.x": "'?' is not expected",
    "acc->x": "'>' is not expected",
    "acc::x": "':' is not expected",
    "acc\\x": "is not expected",
    "\u201cacc.x\u201d": "in double quotes",
    "a[b/c=1]": "in double quotes",
    "a[0:3]": "in double quotes",
    "a[b=True]": 'write true, or "True" in double quotes for the text',
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_path_that_cannot_mean_anything_is_refused_in_a_line_that_says_what_to_do(
    text: str,
) -> None:
    with pytest.raises(MappingError, match=re.escape(REFUSED[text])) as caught:
        parse_path(text)
    assert str(caught.value).startswith(f"{text!r} is not a path: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["T", "T=", "=1", "T==1", "T=1=2", "T=1|2", "T>=5", 'T="a', "[*].T=1", "T[*]=1", "-T=1"]
)
def test_a_condition_that_cannot_mean_anything_is_refused(text: str) -> None:
    with pytest.raises(MappingError, match="is not a condition such as T=1002"):
        parse_condition(text)


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("T=True", 'write true, or "True" in double quotes for the text'),
        ("T!=FALSE", 'write false, or "FALSE" in double'),
        ("T=Null", 'write null, or "Null" in double'),
        ("T=None", 'write null, or "None" in double'),
        ("T=+5", 'write the number as in JSON, or "+5" in double'),
        ("T=.5", "write the number as in JSON"),
        ("T=5.", "write the number as in JSON"),
        ("T=-007", "write the number as in JSON"),
    ],
)
def test_a_value_that_is_nearly_another_is_refused_with_the_way_to_write_either(
    text: str, cure: str
) -> None:
    with pytest.raises(MappingError, match=re.escape(cure)):
        parse_condition(text)


@pytest.mark.parametrize("text", ['T="True"', "T=007", "T=none", "T=1.2.3", "T=on", "T=5 V"])
def test_a_value_that_is_like_no_other_is_a_text(text: str) -> None:
    assert parse_condition(text).value == text[2:].strip('"')


@given(st.text(st.sampled_from('ab01.[]*|="!- $\\'), max_size=12))
def test_any_text_is_a_path_that_can_be_shown_or_is_refused_in_one_line(text: str) -> None:
    said = refusal(text)
    assert "\n" not in said
    for way in parse_path(text) if not said else ():
        assert parse_path(show_steps(way.steps)) == (Way(way.steps),)


@given(st.randoms(use_true_random=False))
def test_every_path_can_be_shown_as_it_may_be_written(rng: Random) -> None:
    fields = make_cases(rng, 1)[0].fields
    for text in (path for name in fields if name.endswith("_paths") for path in fields[name]):
        for way in parse_path(text) if not refusal(text) else ():
            assert parse_path(show_steps(way.steps)) == (Way(way.steps),)


def refusal(text: str) -> str:
    try:
        parse_path(text)
    except MappingError as error:
        return str(error)
    return ""


def vectors(acceleration: tuple[str, ...], rate: tuple[str, ...], **fields: Any) -> ImuMapping:
    return ImuMapping(
        linear_acceleration_paths=acceleration,
        linear_acceleration_unit="g",
        angular_velocity_paths=rate,
        angular_velocity_unit="deg/s",
        **fields,
    )


TWO_THINGS = {
    "one list for two quantities": (("xyz",), ("xyz",)),
    "the same key": (("a.x", "a.y", "a.z"), ("g.x", "g.y", "a.z")),
    "a list and its elements": (("v",), ("v.2", "v.3", "v.4")),
    "a condition on one of them": (("[kind=acc].xyz",), ("xyz",)),
    "the same condition": (("[kind=acc].xyz",), ("[kind=acc].xyz",)),
    "conditions that both may hold": (("[kind=acc].xyz",), ("[on=true].xyz",)),
    "conditions that exclude the same": (("[kind!=acc].xyz",), ("[kind!=gyr].xyz",)),
    "another alternative": (("acc|xyz",), ("gyr|xyz",)),
    "an element and every element": (("a[*].v",), ("a[*].v",)),
    "a minus": (("-xyz",), ("xyz",)),
}


@pytest.mark.parametrize("name", TWO_THINGS)
def test_what_can_mean_two_quantities_is_refused_with_the_cure(name: str) -> None:
    with pytest.raises(MappingError, match=r"tell them apart by a condition, such as \[kind=acc\]"):
        vectors(*TWO_THINGS[name]).compile()


@pytest.mark.parametrize(
    ("acceleration", "rate"),
    [
        (("[kind=acc].xyz",), ("[kind=gyr].xyz",)),
        (("[kind=acc].xyz",), ("[kind!=acc].xyz",)),
        (("s[id=1].v",), ("s[id=2].v",)),
        (("s[id=1][on=true].v",), ("s[id=2][on=true].v",)),
        (("v[0]", "v[1]", "v[2]"), ("v[3]", "v[4]", "v[5]")),
        (("s[0].v",), ("s[1].v",)),
        (("a[*][0]", "a[*][1]", "a[*][2]"), ("a[*][3]", "a[*][4]", "a[*][5]")),
    ],
)
def test_what_conditions_or_places_tell_apart_is_taken(
    acceleration: tuple[str, ...], rate: tuple[str, ...]
) -> None:
    vectors(acceleration, rate).compile()


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"linear_acceleration_paths": ("x", "y", "x")}, "two components of linear_acceleration"),
        ({"linear_acceleration_paths": ("x", "y", "-x")}, "are both at x"),
        ({"linear_acceleration_paths": ("x", "0", '"0"')}, "are both at [0]"),
        ({"linear_acceleration_paths": ("x[*]", "y[*]", "z")}, "[*] is in all paths of all"),
        ({"select": ("T=1", "T=2")}, "mapping.select is never met: T=1 and T=2"),
        ({"select": ('T="a"', "T!=a")}, "mapping.select is never met"),
        ({"angular_velocity_unit": "deg/s"}, "mapping.angular_velocity.unit has no effect"),
        ({"orientation_order": "wxyz"}, "mapping.orientation.order has no effect"),
        ({"absent": "null"}, "mapping.absent is missing or zero, not 'null'"),
        ({"time_interval": "5 ms"}, "mapping.time.interval has no effect"),
        ({"time_paths": ("s", "ns"), "time_unit": "s"}, "mapping.time.unit has no effect"),
        ({"time_unit": "s"}, "mapping.time.unit has no effect"),
        ({"time_paths": ("-t",), "time_unit": "s"}, "takes no minus"),
        ({"time_paths": ("t", "t")}, "two components of the time are both at t"),
        ({"time_paths": ("acc[0]",), "time_unit": "s"}, "and the time are both at acc[0]"),
        ({"time_paths": ("t[*]",), "time_unit": "s"}, "[*] is in all of mapping.time.paths"),
    ],
)
def test_a_mapping_that_can_mean_nothing_or_has_no_effect_is_refused(
    fields: dict[str, Any], complaint: str
) -> None:
    known = {"linear_acceleration_paths": ("acc",), "linear_acceleration_unit": "g"}
    mapping = ImuMapping(**{**known, **fields})
    with pytest.raises(MappingError, match=re.escape(complaint)):
        mapping.compile(device_time=bool(mapping.time_paths))


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"time_paths": ("t",), "time_unit": "s"}, "one date for several samples"),
        ({"time_paths": ("t[*]", "ns")}, "[*] is in all of mapping.time.paths"),
        ({"time_interval": "5"}, "write a number or a path and its unit"),
        ({"time_interval": "5 min"}, "such as '5 ms', '200 Hz' or 'rate Hz'"),
        ({"time_interval": "0 Hz"}, "up to a minute"),
        ({"time_interval": "1e9 s"}, "up to a minute"),
        ({"time_interval": "a[*] Hz"}, "has no [*]"),
        ({"time_interval": "a..b Hz"}, "'a..b' is not a path"),
    ],
)
def test_the_time_of_several_samples_must_be_told(fields: dict[str, Any], complaint: str) -> None:
    known = {"linear_acceleration_paths": ("acc[*]",), "linear_acceleration_unit": "g"}
    mapping = ImuMapping(**{**known, **fields})
    with pytest.raises(MappingError, match=re.escape(complaint)):
        mapping.compile(device_time=bool(mapping.time_paths))
