"""What a mapping must not take for a number, a zero, a date or a sample."""

import json
import re
from collections.abc import Iterator
from itertools import count
from typing import Any

import pytest
from attrs import evolve
from hypothesis import event, given, settings
from hypothesis import strategies as st

from rosbase.errors import MappingError
from rosbase.imu.mapping import ImuMapping, Sample
from rosbase.mapping.assembly import Batch
from rosbase.mapping.clashes import check_clashes
from rosbase.mapping.dates import date_ns
from rosbase.mapping.path_text import parse_path
from rosbase.mapping.rejects import Reject
from support.mapping_oracle import NOTHING, SURPLUS, way_of, with_index

XYZ = ("acc.x", "acc.y", "acc.z")
NEW_OR_OLD = ("new.x|old.x", "new.y|old.y", "new.z|old.z")
NO_DATA = "no_imu_data"


def mapping(acc: tuple[str, ...], gyr: tuple[str, ...] = (), **fields: Any) -> ImuMapping:
    found: dict[str, Any] = {
        "linear_acceleration_paths": acc,
        "linear_acceleration_unit": "m/s^2",
        **fields,
    }
    if gyr:
        found |= {"angular_velocity_paths": gyr, "angular_velocity_unit": "rad/s"}
    return ImuMapping(**found)


def read(
    found: ImuMapping, payload: Any, *, device_time: bool = False
) -> Sample | Reject | Batch[Sample]:
    return found.compile(device_time=device_time)(json.dumps(payload).encode())


def acc_or_reason(found: Sample | Reject | Batch[Sample]) -> Any:
    if isinstance(found, Batch):
        return [acc_or_reason(sample) for sample in found.samples]
    return found.reason if isinstance(found, Reject) else found.linear_acceleration


# One value for two quantities.


@pytest.mark.parametrize(
    ("acc", "gyr"),
    [
        ("sensors[id=acc].v", "sensors[0].v"),
        ("sensors[0].v", "sensors[id=acc].v"),
        ("sensors[id=acc].v", "sensors[0][on=true].v"),
        ("imu.list[kind!=gyr].v", "imu.list[1].v"),
        ("s[0].list[id=1].v", "s[id=a].list[0].v"),
        ("frames[kind=acc][*].v", "frames[*].v"),
        ("frames[kind=acc][*].v", "frames[*][on=true].v"),
        ("a[0].b", 'a."0".b'),
    ],
)
def test_an_index_and_a_condition_that_may_be_one_element_are_refused(acc: str, gyr: str) -> None:
    with pytest.raises(MappingError, match="tell them apart by a condition"):
        mapping((acc,), (gyr,)).compile()


@pytest.mark.parametrize(
    ("acc", "gyr"),
    [
        ("sensors[id=acc].v", "sensors[0][id=gyr].v"),
        ("sensors[id=acc].v", "sensors[0].w"),
        ("frames[kind=acc][*].v", "frames[*][kind=gyr].v"),
        ("frames[kind=acc][*].v", "frames[kind=gyr][*].v"),
        ("s[id=1][0].v", "s[id=2][0].v"),
        ("sensors[id=acc].v", "sensors.v2"),
    ],
)
def test_conditions_of_the_same_element_tell_them_apart(acc: str, gyr: str) -> None:
    mapping((acc,), (gyr,)).compile()


STEP = st.sampled_from([".a", "[0]", "[1]", "[k=1]", "[k=2]", "[k!=1]", "[0=1]", "[*]", '."0"'])
PATHS = st.lists(STEP, min_size=1, max_size=3).map(lambda steps: "".join(steps).lstrip("."))
PLACES = st.recursive(
    st.just(0),
    lambda inner: (
        st.lists(inner, min_size=1, max_size=3)
        | st.fixed_dictionaries({"k": st.sampled_from([1, 2])}, optional={"a": inner, "0": inner})
    ),
    max_leaves=8,
)


def number_each(value: Any, numbers: Iterator[int]) -> Any:
    """The value with another number in place of each zero."""
    if isinstance(value, list):
        return [number_each(one, numbers) for one in value]
    if isinstance(value, dict):
        return {key: number_each(one, numbers) for key, one in value.items()}
    return value or next(numbers)


@settings(max_examples=1000)
@given(PATHS, PATHS, PLACES)
def test_two_paths_that_are_taken_never_lead_to_one_value(one: str, other: str, place: Any) -> None:
    try:
        ((first,), (second,)) = parse_path(one), parse_path(other)
        check_clashes({"acc": [[first.steps]], "gyr": [[second.steps]]})
    except MappingError:
        event("refused")
        return
    payload = number_each(place, count(1000))
    ways = [way_of(path, {})[1] for path in (one, other)]
    found = [
        {id(f) for k in range(3) if (f := with_index(payload, way, k)) not in (NOTHING, SURPLUS)}
        for way in ways
    ]
    event("both lead to something" if all(found) else "one leads to nothing")
    assert not found[0] & found[1]


def test_long_paths_are_compared_in_no_time() -> None:
    long = "a" + "[0]" * 400
    with pytest.raises(MappingError, match="are both at"):
        mapping((long,), (long,)).compile()
    mapping((f"{long}.v",), (f"{long}.w",)).compile()


# Zeros that are left out.


@pytest.mark.parametrize(
    ("paths", "payload", "expected"),
    [
        (XYZ, {"acc": {}}, (0.0, 0.0, 0.0)),
        (XYZ, {"acc": {"z": 9.8}}, (0.0, 0.0, 9.8)),
        (XYZ, {"acc": {"z": 9.8, "temp": 21}}, (0.0, 0.0, 9.8)),
        # An error, or something else, in place of the numbers.
        (XYZ, {"acc": {"error": "i2c timeout"}}, NO_DATA),
        (XYZ, {"acc": {"status": 5, "code": -1}}, NO_DATA),
        (XYZ, {"acc": {"roll": 1.0, "pitch": 2.0}}, NO_DATA),
        (XYZ, {"acc": {"acc": {"x": 1, "y": 2, "z": 9.8}}}, NO_DATA),
        (("s[id=a].x", "s[id=a].y", "s[id=a].z"), {"s": [{"id": "a"}]}, (0.0, 0.0, 0.0)),
        (("s[id=a].x", "s[id=a].y", "s[id=a].z"), {"s": [{"id": "a", "error": 5}]}, NO_DATA),
        # Another spelling.
        (XYZ, {"acc": {"X": 0.1, "Y": 0.2, "Z": 9.8}}, "incomplete"),
        (XYZ, {"acc": {"x": 0.1, "y": 0.2, "Z": 9.8}}, "incomplete"),
        (("ax", "ay", "az"), {"ax": 0.1, "ay": 0.2, "aZ": 9.8}, "incomplete"),
        (("aX", "aY", "aZ"), {"aX": 0.1, "AY": 0.2, "aZ": 9.8}, "incomplete"),
        (("x.v", "y.v", "z.v"), {"x": {"v": 0.1}, "y": {"v": 0}, "Z": {"v": 9.8}}, "incomplete"),
        # Part of a vector that is something else.
        (("x.v", "y.v", "z.v"), {"x": {"v": 0.1}, "z": {"v": 9.8}}, (0.1, 0.0, 9.8)),
        (("x.v", "y.v", "z.v"), {"x": {"v": 0.1}, "y": {}, "z": {"v": 9.8}}, (0.1, 0.0, 9.8)),
        (("x.v", "y.v", "z.v"), {"x": {"v": 1}, "y": {"error": 5}, "z": {"v": 2}}, "incomplete"),
        (("x.v", "y.v", "z.v"), {"x": {"v": 1}, "y": "N/A", "z": {"v": 2}}, "incomplete"),
        (("s[id=a].v", "s[id=b].v", "s[id=c].v"), {"s": [{"id": "a", "v": 1}]}, "incomplete"),
        # Of alternatives, one with a value.
        (NEW_OR_OLD, {"new": {}, "old": {"x": 1, "y": 2, "z": 9.8}}, (1.0, 2.0, 9.8)),
        (NEW_OR_OLD, {"new": {"X": 5}, "old": {"x": 1, "y": 2, "z": 9.8}}, (1.0, 2.0, 9.8)),
        (NEW_OR_OLD, {"new": {}, "old": {"x": "bad"}}, "wrong_type"),
        (NEW_OR_OLD, {"new": {}, "old": {}}, (0.0, 0.0, 0.0)),
        (NEW_OR_OLD, {"new": {"z": 9.8}, "old": {"x": 1}}, (0.0, 0.0, 9.8)),
        (
            ("d[*].x|e[*].x", "d[*].y|e[*].y", "d[*].z|e[*].z"),
            {"d": [{}, {}], "e": [{"z": 9.8}, {}]},
            [(0.0, 0.0, 9.8), (0.0, 0.0, 0.0)],
        ),
        (
            ("d[*].x", "d[*].y", "d[*].z"),
            {"d": [{"z": 9.8}, {"error": 5}, {"Z": 9.8}, {}]},
            [(0.0, 0.0, 9.8), NO_DATA, "incomplete", (0.0, 0.0, 0.0)],
        ),
    ],
)
def test_only_what_an_encoder_leaves_out_is_zero(
    paths: tuple[str, ...], payload: Any, expected: Any
) -> None:
    assert acc_or_reason(read(mapping(paths, absent="zero"), payload)) == expected


def test_keys_of_other_quantities_do_not_hide_zeros_and_are_no_other_spelling() -> None:
    both = mapping(("i.x", "i.y", "i.z"), ("i.X", "i.Y", "i.Z"), absent="zero")
    found = read(both, {"i": {"X": 0.5, "seq": 7}})
    assert isinstance(found, Sample)
    assert found[1:3] == ((0.5, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_nanoseconds_with_another_spelling_are_not_zero() -> None:
    dated = mapping(("acc",), absent="zero", time_paths=("t.sec", "t.nsec"))
    for stamp, date in (
        ({"sec": 1_812_345_678}, 1_812_345_678_000_000_000),
        ({"sec": 1_812_345_678, "nSec": 5}, None),
        ({"sec": 1_812_345_678, "nanosec": 5}, 1_812_345_678_000_000_000),
    ):
        found = read(dated, {"acc": [0, 0, 9.8], "t": stamp}, device_time=True)
        assert isinstance(found, Sample)
        assert found.device_time_ns == date


# More samples than are read.

ACC_FIRST = ("v[0]", "v[1]", "v[2]")
ACC_SECOND = ("v[1]", "v[2]", "v[3]")
SIX = [0, 0, 9.8, 1, 2, 3]


@pytest.mark.parametrize(
    ("acc", "gyr", "numbers", "fields", "is_one"),
    [
        ((), ("v[3]", "v[4]", "v[5]"), SIX * 2, {}, False),
        ((), ("v[3]", "v[4]", "v[5]"), SIX, {}, True),
        (ACC_SECOND, (), [100, 0, 0, 9.8, 105, 0, 1, 9.8, 110, 0, 2, 9.8], {}, False),
        (ACC_SECOND, (), [100, 0, 0, 9.8], {}, True),
        # What stands before the first number is there once.
        (ACC_SECOND, (), [100, 0, 0, 9.8, 0, 1, 9.8, 0, 2, 9.8], {}, False),
        (ACC_SECOND, (), ["imu", 0, 0, 9.8, 0, 1, 9.8], {"select": ("v[0]=imu",)}, False),
        (ACC_SECOND, ("v[4]", "v[5]", "v[6]"), [100, *SIX, 105, *SIX], {}, False),
        (ACC_SECOND, ("v[4]", "v[5]", "v[6]"), [100, *SIX, 21.5], {}, True),
        (("v[2]", "v[1]", "-v[0]"), (), [0, 0, 9.8] * 5, {}, False),
        (("v[0]", "v[1]", "v[3]"), (), [0, 0, 5, 9.8] * 2, {}, False),
        # A part of a flat array: the mapping says how long a sample is.
        (ACC_SECOND, (), [100, *SIX, 21.5], {}, False),
        (ACC_SECOND, (), [100, *SIX, 21.5], {"select": ("v[7]!=null",)}, True),
        (ACC_SECOND, (), [100, *SIX, 21.5] * 2, {"select": ("v[7]!=null",)}, False),
        (ACC_FIRST, (), SIX, {"select": ("v[5]!=null",)}, True),
        (ACC_FIRST, (), [*SIX, 21.5], {}, True),
    ],
)
def test_numbers_side_by_side_that_are_more_than_one_sample_are_refused(
    acc: tuple[str, ...],
    gyr: tuple[str, ...],
    numbers: list[Any],
    fields: dict[str, Any],
    is_one: bool,
) -> None:
    known = mapping(acc or ("other",), gyr, **fields)
    found = read(known, {"v": numbers})
    if is_one:
        assert isinstance(found, Sample)
    else:
        assert isinstance(found, Reject)
        assert found.reason == "surplus"
        assert f"v[{len(numbers) - 1}]!=null" in found.detail


def test_the_length_of_lists_in_a_list_can_be_said_too() -> None:
    paths = ("f[*][1]", "f[*][2]", "f[*][3]")
    payload = {"f": [[100, *SIX, 21.5], [105, *SIX, 21.5]]}
    assert acc_or_reason(read(mapping(paths), payload)) == ["surplus", "surplus"]
    told = mapping(tuple(path.replace("f", "f[7!=null]") for path in paths))
    assert acc_or_reason(read(told, payload)) == [(0.0, 0.0, 9.8)] * 2


# Dates.

S = 1_000_000_000


@pytest.mark.parametrize(
    ("pair", "expected"),
    [
        ((1_795_897_337, 14_276_504), 1_795_897_337 * S + 14_276_504),
        ((1_795_897_337.0, 14_276_504.0), 1_795_897_337 * S + 14_276_504),
        (("1795897337", "999999999"), 1_795_897_337 * S + 999_999_999),
        (("2026-11-28T20:22:17Z", 14_276_504), 1_795_897_337 * S + 14_276_504),
        ((1_795_897_337.014277, 14_276_504), "the seconds have a fraction"),
        (("1795897337.5", 0), "the seconds have a fraction"),
        (("2026-11-28T20:22:17.014276Z", 14_276_504), "the seconds have a fraction"),
        ((1_795_897_337, S), "more than a second"),
        ((1_795_897_337, -1), "negative"),
        ((1_795_897_337, 14_276_504_000), "more than a second"),
        ((1_795_897_337, "1970-01-01T00:00:00.5Z"), "is no number of nanoseconds"),
    ],
)
def test_a_pair_is_whole_seconds_and_the_nanoseconds_after_them(
    pair: tuple[object, object], expected: int | str
) -> None:
    found = date_ns(pair, [S, 1], numeric_strings=True)
    assert expected in found.detail if isinstance(found, Reject) else found == expected  # type: ignore[operator]  # a text where it is a Reject


NOON = 1_812_345_678


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2027-06-07t05:21:18z", NOON * S),
        ("2027-06-07 05:21:18.25z", NOON * S + S // 4),
        (" 2027-06-07T05:21:18Z\n", NOON * S),
        ("20270607T052118Z", NOON * S),
        ("2027-06-07T05:21:18,25Z", NOON * S + S // 4),
        ("2027-06-07T00:21:18\u221205:00", NOON * S),
        ("2027-06-06T24:00:00Z", 1_812_326_400 * S),
        ("20270606T2400Z", 1_812_326_400 * S),
        ("2027-06-06T24:00:00.000+05:30", 1_812_326_400 * S - 19_800 * S),
        ("2027-W23-1T05:21:18Z", NOON * S),
        ("2027W23T052118Z", NOON * S),
        ("2027-06-07T05:21Z", (NOON - 18) * S),
        ("2027-06-07T07+02", (NOON - 1_278) * S),
        ("2027-06-07T10:51:18.123456789+0530", NOON * S + 123_456_000),
        ("2016-12-31T23:59:60Z", 1_483_228_800 * S),
        ("2017-01-01T05:29:60.5+05:30", 1_483_228_800 * S + S // 2),
        (" 1812345678\u00a0", NOON * S),
        ("2027-06-07T23:59:60Z", "is no leap second"),
        ("2016-12-31T23:59:60", "has no time zone"),
        ("2027-06-07T24:00:01Z", "is no date"),
        ("2027-06-07T23:59:61Z", "is no date"),
        ("2027-06-07T05:60:18Z", "is no date"),
        ("2027-02-30T00:00:00Z", "is no date"),
        ("2027-0607T05:21:18Z", "is no date"),
        ("2027-W54-1T05:21:18Z", "is no date"),
        ("2027-06-07T05:21:18+24:00", "is no date"),
        ("9999-12-31T23:59:60Z", "is no leap second"),
        ("2027-06-07", "has no time zone"),
        ("1e999", "'1e999' is no date"),
        ("1" * 5_000, "'1111"),
    ],
)
def test_dates_are_as_rfc_3339_and_iso_8601_allow_them(text: str, expected: int | str) -> None:
    found = date_ns([text], [S], numeric_strings=True)
    assert expected in found.detail if isinstance(found, Reject) else found == expected  # type: ignore[operator]  # a text where it is a Reject


# Numbers in quotes.


@pytest.mark.parametrize(
    ("condition", "value", "holds"),
    [
        ("k=-1", "-1", True),
        ("k=-1", " -1.0 ", True),
        ("k=1002", "1002", True),
        ("k=9007199254740993", "9007199254740993", True),
        ("k=9007199254740993", "9007199254740992", False),
        ("k!=-1", "-1", False),
        ("k!=-1", "-1e0", False),
        ("k!=-1", "0", True),
        ("k=1", "one", False),
        ("k=1", "1" * 5_000, False),
        ("k=1", True, False),
        ("k=true", "true", False),
        ('k="1"', "1", True),
        ('k="1"', 1, False),
        ('k="1"', "1.0", False),
    ],
)
@pytest.mark.parametrize("form", ["select", "path", "element", "nested"])
def test_a_condition_takes_a_text_for_a_number_if_the_mapping_does(
    condition: str, value: Any, holds: bool, form: str
) -> None:
    nested = condition.replace("k", "k[0]", 1)
    known, payload = {
        "select": (mapping(("v",), select=(condition,)), {"k": value, "v": [0, 0, 9.8]}),
        "path": (mapping((f"[{condition}].v",)), {"k": value, "v": [0, 0, 9.8]}),
        "element": (mapping((f"s[{condition}].v",)), {"s": [{"k": value, "v": [0, 0, 9.8]}]}),
        "nested": (mapping((f"[{nested}].v",)), {"k": [value], "v": [0, 0, 9.8]}),
    }[form]
    found = read(evolve(known, numeric_strings=True), payload)
    assert isinstance(found, Sample) is holds
    strict = read(known, payload)
    is_number = '"' not in condition and isinstance(value, str)
    assert isinstance(strict, Sample) is ("!=" in condition if is_number else holds)


def test_conditions_on_a_number_and_on_its_text_may_both_hold() -> None:
    mapping(("v",), select=("k=1", 'k="1"'), numeric_strings=True).compile()
    with pytest.raises(MappingError, match="never met"):
        mapping(("v",), select=("k=1", 'k="1"')).compile()


# What can mean nothing.


@pytest.mark.parametrize(
    ("paths", "select", "complaint"),
    [
        (("[kind=gyr].v",), ("kind=acc",), 'never at [kind="gyr"].v[0]: there, kind="acc" holds'),
        (("v|[kind=gyr].v",), ("kind=acc",), 'there, kind="acc" holds'),
        (("imu[kind=gyr].v",), ("imu.kind=acc",), 'there, imu.kind="acc" holds'),
        (("[kind!=acc].v",), ("kind=acc",), 'there, kind="acc" holds'),
        (("acc.v",), ("acc=1",), "never at acc.v[0]: there, acc=1 holds"),
        (("acc",), ("acc=1",), "there, acc=1 holds"),
        (("acc.v",), ("acc=null",), "there, acc=null holds"),
        (("a[b=1].b.c",), (), "there, b=1 holds"),
        (("s[id=1].id.v",), (), "there, id=1 holds"),
        (("v",), ("a=1", "a.b=2"), "never met: a=1 and a.b=2"),
        (("x", "y", "z[k=1]"), (), "objects and lists meet conditions, numbers do not"),
        (("a", "a.b", "a.c"), (), "a is a number, and has no a.b"),
        (("a.b.c", "a.b", "z"), (), "a.b is a number, and has no a.b.c"),
        (("x", "y", "y[k=1].z"), (), "y is a number"),
        (("a[0]", "a.y", "a.z"), (), 'a is a list or an object, not both: a[0] and a.y; write "0"'),
        (("x", "[1]", "z"), (), "the payload is a list or an object"),
        (("a.x[*]", "a[*].y", "a[*].z"), (), "a is a list or an object, not both"),
    ],
)
def test_paths_that_never_lead_to_a_number_are_refused(
    paths: tuple[str, ...], select: tuple[str, ...], complaint: str
) -> None:
    with pytest.raises(MappingError, match=re.escape(complaint)):
        mapping(paths, select=select).compile()


@pytest.mark.parametrize(
    ("paths", "select"),
    [
        (("[kind=acc].v",), ("kind=acc",)),
        # A list of objects is not of the kind `gyr`, and may have an element that is.
        (("[kind=gyr].v",), ("kind!=gyr",)),
        (("[kind=gyr].v",), ("[0].kind=acc",)),
        (("sensors[0].v",), ("sensors[0].id=acc",)),
        (("s[id=1].v",), ("s[0].id=2",)),
        (("acc.v",), ("acc!=1",)),
        (("acc.v",), ("acc|a=1",)),
        (('a."0"', "a.y", "a.z"), ()),
        (("a[0]", "b.y", "c.z"), ()),
        (("s[id=1].x", "s[0].y", "s[id=2].z"), ()),
    ],
)
def test_paths_that_may_lead_to_a_number_are_taken(
    paths: tuple[str, ...], select: tuple[str, ...]
) -> None:
    mapping(paths, select=select).compile()
