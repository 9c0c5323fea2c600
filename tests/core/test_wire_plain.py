"""Messages known by their schema alone: the same values as with their class, in both directions."""

import contextlib
import math
import subprocess
import sys
import tracemalloc
from typing import Annotated, Any

import pytest
from attrs import frozen
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import WireError
from rosbase.messages import Header, Image, Imu, JointState, Quaternion
from rosbase.messages.fields import AtMost, Int32, UInt8, message
from rosbase.messages.widths import Width
from rosbase.wire import describe, schema, serialize, type_hash
from rosbase.wire.hashes import hash_of
from rosbase.wire.plain import decoder, encoder
from rosbase.wire.schema_text import parse_schema
from support.wire_messages import CLASSES, Rolled, made, messages_of, name_of

BY_NAME = {name_of(cls): cls for cls in CLASSES}


@message("my_msgs/msg/Tuned")
@frozen
class Tuned:
    gain: float = 1.5
    name: str = 'a "b" # c'
    count: Int32 = -3
    is_on: bool = True
    steps: tuple[UInt8, UInt8, UInt8] = (1, 2, 3)
    words: Annotated[tuple[str, ...], AtMost(4)] = ("x, y", "z")
    limit: float = math.inf


def plain(value: Any) -> Any:
    """A message of a class as plain data."""
    kind = type(value)
    if hasattr(kind, "__ros_type__"):
        return {one.alias: plain(getattr(value, one.name)) for one in describe(kind).fields}
    if isinstance(value, tuple):
        return [plain(one) for one in value]
    return value if isinstance(value, (str, int, float)) else memoryview(value).tolist()


def listed(value: Any) -> Any:
    """Plain data with lists in place of views and tuples."""
    if isinstance(value, dict):
        return {name: listed(one) for name, one in value.items()}
    if isinstance(value, (tuple, bytes, memoryview)):
        return [listed(one) for one in value]
    return value


def same(left: Any, right: Any) -> bool:
    """Whether the two are equal; NaN equals itself."""
    return repr(left) == repr(right)


@pytest.mark.parametrize("cls", [*CLASSES, Tuned], ids=name_of)
def test_a_parsed_schema_is_the_type_of_its_class(cls: type) -> None:
    parsed = parse_schema(name_of(cls), schema(cls, with_defaults=True))
    assert hash_of(parsed) == type_hash(cls)
    assert [tuple(one) for one in parsed.constants] == [
        tuple(one) for one in describe(cls).constants
    ]
    assert [one.default for one in parsed.fields] == [one.default for one in describe(cls).fields]


@pytest.mark.parametrize("cls", [*CLASSES, Tuned], ids=name_of)
def test_a_message_without_values_has_the_defaults_of_its_class(cls: Any) -> None:
    assert encoder(name_of(cls), schema(cls, with_defaults=True))({}) == serialize(cls())
    assert encoder(name_of(cls), schema(cls, with_defaults=True))(None) == serialize(cls())


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_plain_data_has_what_the_reader_of_the_class_has(cls: Any) -> None:
    own = made(describe(cls), Rolled(31))
    data = serialize(own)
    read = decoder(name_of(cls), schema(cls, with_defaults=True))(data)
    assert same(listed(read), plain(own))
    assert encoder(name_of(cls), schema(cls, with_defaults=True))(read) == data
    assert encoder(name_of(cls), schema(cls, with_defaults=True))(listed(read)) == data


@given(st.data())
def test_any_message_is_read_and_written_as_by_its_class(data: st.DataObject) -> None:
    cls = BY_NAME[data.draw(st.sampled_from(sorted(BY_NAME)))]
    written = serialize(data.draw(messages_of(cls)))
    read = decoder(name_of(cls), schema(cls, with_defaults=True))(written)
    assert encoder(name_of(cls), schema(cls, with_defaults=True))(read) == written


def test_long_sequences_of_numbers_are_views_and_short_arrays_are_tuples() -> None:
    read = decoder("sensor_msgs/msg/Image", schema(Image))
    data = serialize(Image(height=1, width=3, encoding="mono8", step=3, data=b"abc"))
    assert read(data)["data"].obj is data
    imu = decoder("sensor_msgs/Imu", schema(Imu))(serialize(Imu()))
    assert imu["orientation_covariance"] == (0.0,) * 9
    states = decoder("sensor_msgs/msg/JointState", schema(JointState))
    position = states(serialize(JointState(name=("a",), position=(1.5,))))["position"]
    assert (position.format, position.tolist()) == ("d", [1.5])


def test_values_may_be_given_as_ros2_topic_pub_takes_them() -> None:
    write = encoder("my_msgs/msg/Tuned", schema(Tuned, with_defaults=True))
    given = {"gain": "2", "name": 5, "count": "0x10", "is_on": "false", "words": [1, "b"]}
    usual = Tuned(gain=2.0, name="5", count=16, is_on=False, words=("1", "b"))
    assert write(given) == serialize(usual)
    assert write({"gain": 3, "count": 4.0, "is_on": 0}) == serialize(
        Tuned(gain=3.0, count=4, is_on=False)
    )


def test_now_and_auto_are_the_date_where_there_is_one() -> None:
    write = encoder("std_msgs/msg/Header", schema(Header), lambda: 1_500_000_007)
    stamped = serialize(Header(Header().stamp.from_nanoseconds(1_500_000_007)))
    assert write("auto") == write({"stamp": "now"}) == stamped  # type: ignore[arg-type]  # a word
    with pytest.raises(TypeError, match=r"^Header.stamp takes fields"):
        encoder("std_msgs/msg/Header", schema(Header))({"stamp": "now"})


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"orientatoin": {}}, "Imu has no field orientatoin; did you mean orientation?"),
        ({"header": {"x": 1}}, "Imu.header has no field x: it has stamp, frame_id"),
        ({"orientation": 3}, "Imu.orientation takes fields with their values, not 3"),
        ({"orientation": {"x": "wide"}}, "Imu.orientation.x takes float64, not 'wide'"),
        ({"header": {"stamp": {"sec": 1 << 40}}}, "Imu.header.stamp.sec takes whole numbers"),
        ({"header": {"frame_id": ["a"]}}, "Imu.header.frame_id takes text"),
        ({"orientation_covariance": [1.0]}, "Imu.orientation_covariance takes 9 elements, not 1"),
        ({"orientation_covariance": "none"}, "Imu.orientation_covariance takes a list"),
        ({"orientation_covariance": {}}, "Imu.orientation_covariance takes a list"),
        ([1], "Imu takes fields with their values"),
    ],
)
def test_a_wrong_value_is_named_with_its_place(values: Any, text: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        encoder("sensor_msgs/msg/Imu", schema(Imu))(values)
    assert str(caught.value).startswith(text)
    assert "\n" not in str(caught.value)


def test_a_schema_as_people_write_it_is_read() -> None:
    text = """
# A comment.
int32 MOST=10 # ten
string WORD='it # is'   # a word
string BARE=it's  # bare
Header header
Part part   # of this package
geometry_msgs/Point[2] corners
string<=8[<=3] names ["a # 1", 'b, c']
uint8[] data
bool class true
================================================================================
MSG: my_msgs/Part
byte[3] raw [1,2 , 3]
================================================================================
MSG: std_msgs/Header
string frame_id
================================================================================
MSG: geometry_msgs/Point
float32 x 0.5
"""
    own = parse_schema("my_msgs/Whole", text.replace("\n", "\r\n"))
    assert [tuple(one) for one in own.constants] == [
        ("MOST", Width.INT32, 10),
        ("WORD", Width.STRING, "it # is"),
        ("BARE", Width.STRING, "it's"),
    ]
    read, write = decoder("my_msgs/Whole", text), encoder("my_msgs/Whole", text)
    assert listed(read(write({"class": False}))) == {
        "header": {"frame_id": ""},
        "part": {"raw": [1, 2, 3]},
        "corners": [{"x": 0.5}, {"x": 0.5}],
        "names": ["a # 1", "b, c"],
        "data": [],
        "class": False,
    }
    assert read(write({"data": b"xy"}))["data"] == b"xy"
    assert read(write(None))["class"] is True


CHAIN = "".join(f"{'=' * 80}\nMSG: a/T{n}\nT{n + 1} x\nT{n + 1} y\n" for n in range(1, 60))
DEEP = "".join(f"{'=' * 80}\nMSG: a/T{n}\nT{n + 1}[] x\n" for n in range(1, 2000))


@pytest.mark.parametrize(
    "text",
    [
        "Unknown x",
        "float64",
        "float64 x y",
        "float64[0] x",
        "float64[<=] x",
        "float64[<=0] x",
        "float64<=3 x",
        "float64 x\nfloat64 x",
        "float64 1x",
        "float64 __class__",
        "float64 x; import os",
        "int8 x 300",
        "int8 X=300",
        "bool x maybe",
        "int32 x " + "9" * 10_000,
        "float64[2] x 1.0",
        "Whole x",
        "Whole[] x",
        "b/Part x 1\n" + "=" * 80 + "\nMSG: b/Part\n",
        "b/Part X=1\n" + "=" * 80 + "\nMSG: b/Part\n",
        "T1 x\n" + CHAIN + "=" * 80 + "\nMSG: a/T60\nbool z\n",
        "T1[] x\n" + DEEP,
        "float64[999999999] x",
        "A[1000] x\n" + "=" * 80 + "\nMSG: a/A\nB[1000] x\n" + "=" * 80 + "\nMSG: a/B\nint64[99] x",
        "\n".join(f"bool x{n}" for n in range(30_000)),
        "x" * (1 << 21),
        "bool x\n" + "=" * 80 + "\nMSG: ../../x\n",
        "\0",
    ],
)
def test_a_schema_that_is_wrong_or_would_be_too_large_is_a_wire_error(text: str) -> None:
    with pytest.raises(WireError) as caught:
        decoder("a/msg/Whole", text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", ["", "Imu", "a/b/c/d", "a/b\n", "1/x", "a/msg/", "é/X", None])
def test_a_name_that_is_none_is_a_wire_error(name: Any) -> None:
    with pytest.raises(WireError):
        decoder(name, "bool x")


@given(
    st.text(
        st.sampled_from("abT1 \t\n#='\"[]<,\\/_") | st.characters(max_codepoint=0x2FF), max_size=200
    )
    | st.lists(
        st.sampled_from(
            ["int8", " ", "x", "[", "]", "<=3", "=", "'", '"', "#", "\n", "a/B", "\\", ",", "2"]
        ),
        max_size=40,
    ).map("".join),
    st.binary(max_size=60),
)
def test_any_schema_and_any_bytes_are_read_or_refused(text: str, data: bytes) -> None:
    try:
        read, write = decoder("a/msg/B", text), encoder("a/msg/B", text)
        write(None)
        write(read(b"\0\1\0\0" + data))
    except (ValueError, WireError):
        # A value of a garbled message may not be one that can be sent, such as a text with NUL.
        return


@pytest.mark.parametrize("part", ["'", '"', "' ", "\\", "[", ",", " ", "#", "'#", "\"'", "=", "/"])
def test_a_long_line_takes_no_long_time(part: str) -> None:
    for start in ("string x ", "string[] x [", "string X=", "int8 x "):
        text = start + part * (200_000 // len(part))
        for line in (text, f"{text}]", f"{text}'x"):
            with contextlib.suppress(WireError):
                decoder("a/msg/B", line)


def test_garbled_bytes_allocate_nothing_large() -> None:
    read = decoder("sensor_msgs/msg/JointState", schema(JointState))
    data = serialize(JointState(name=("a", "b"), position=(1.0, 2.0)))
    tracemalloc.start()
    try:
        for index in range(4, len(data) - 3):
            with pytest.raises(WireError):
                read(data[:index])
            try:
                read(data[:index] + b"\xff\xff\xff\x7f" + data[index + 4 :])
            except WireError:
                continue
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 500_000


def test_the_default_of_a_quaternion_is_no_rotation() -> None:
    assert "float64 w 1.0\n" in schema(Quaternion, with_defaults=True)
    read = decoder("geometry_msgs/msg/Quaternion", schema(Quaternion, with_defaults=True))
    assert read(serialize(Quaternion())) == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def test_plain_data_needs_neither_attrs_nor_messages() -> None:
    program = """
import sys
import rosbase.wire.plain
heavy = ("attr", "dataclasses", "inspect", "pluggy", "rosbase.messages.fields", "difflib")
print(sorted(name for name in sys.modules if name.startswith(heavy)))
"""
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout == "[]\n"


def test_functions_of_the_package_are_found_whatever_was_imported_before() -> None:
    program = """
import rosbase.wire.class_reader, rosbase.wire.schemas, rosbase.wire.hashes
import rosbase.wire.making, rosbase.wire.packing
import rosbase.wire.class_writer, rosbase.wire.description
from rosbase import wire
print([name for name in wire.__all__ if not callable(getattr(wire, name))])
"""
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout == "[]\n"
