"""How commands print messages, rates and tables. The rules are those of rosidl_runtime_py."""

import csv
import io
import json
import math
import statistics
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.cli.operate.columns import columns, duration, milliseconds, size
from rosbase.cli.operate.message_text import Limits, as_csv, as_json, shortened, writer_for
from rosbase.cli.operate.pool import Pool
from rosbase.cli.operate.reading import Given, read
from rosbase.cli.operate.values import as_call, parsed
from rosbase.cli.operate.words import GROUPS
from rosbase.messages import Imu
from rosbase.messages.sensor_msgs import Image
from rosbase.wire import schema, serialize
from rosbase.wire.plain import decoder

MESSAGE = {
    "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "base"},
    "values": memoryview(b"\x01\x02\x03"),
    "names": ("a", "b"),
    "empty": (),
    "nested": ({"x": 1.5}, {"x": math.nan}),
    "ok": True,
}


def echo(message: Any, *options: str) -> str:
    """What `topic echo` prints for a message."""
    command = GROUPS["topic"].commands["echo"]  # type: ignore[union-attr]  # a group
    return writer_for(Given(read(command, ["/topic", *options])))(message)


def test_yaml_is_that_of_ros2() -> None:
    assert echo(MESSAGE) == (
        "header:\n  stamp:\n    sec: 1\n    nanosec: 2\n  frame_id: base\n"
        "values:\n- 1\n- 2\n- 3\nnames:\n- a\n- b\nempty: []\nnested:\n- x: 1.5\n- x: .nan\n"
        "ok: true\n---\n"
    )


def test_csv_is_that_of_ros2() -> None:
    assert echo(MESSAGE, "--csv") == "1,2,base,1,2,3,a,b,,1.5,nan,True\n"


def test_json_is_one_line_that_every_reader_takes() -> None:
    assert echo(MESSAGE, "--json") == (
        '{"header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "base"}, '
        '"values": [1, 2, 3], "names": ["a", "b"], "empty": [], '
        '"nested": [{"x": 1.5}, {"x": "NaN"}], "ok": true}\n'
    )


def test_json_tells_numbers_that_it_has_not_from_each_other() -> None:
    values = json.loads(echo({"values": (math.nan, math.inf, -math.inf)}, "--json"))["values"]
    assert list(map(repr, map(float, values))) == ["nan", "inf", "-inf"]


def test_forms_for_other_programs_are_cut_only_if_wanted() -> None:
    message = {"text": "x" * 200, "numbers": memoryview(bytes(200))}
    assert json.loads(echo(message, "--json")) == {"text": "x" * 200, "numbers": [0] * 200}
    assert echo(message, "--csv") == f"{'x' * 200}{',0' * 200}\n"
    assert json.loads(echo(message, "--json", "-l", "1"))["numbers"] == [0, "..."]


@given(st.lists(st.text(st.characters(codec="ascii", categories=("L", "P", "Z", "S"))), min_size=1))
def test_texts_in_csv_can_be_read_back(texts: list[str]) -> None:
    written = [*texts, 'a "b", c\nd']
    shown = echo({"number": 1, "texts": written}, "--csv")
    assert list(csv.reader(io.StringIO(shown, newline=""))) == [["1", *written]]


def test_long_lists_and_texts_are_cut_as_by_ros2() -> None:
    message = {"text": "x" * 200, "numbers": memoryview(bytes(200))}
    lines = echo(message).splitlines()
    assert lines[0] == f"text: {'x' * 128}..."
    assert lines[2:] == ["- 0"] * 128 + ["- '...'", "---"]
    assert len(echo(message, "--full-length").splitlines()) == 203
    assert echo(message, "-l", "2") == "text: xx...\nnumbers:\n- 0\n- 0\n- '...'\n---\n"
    assert echo(message, "-l", "2", "--csv") == "xx...,0,0,...\n"
    assert echo(message, "--no-str", "--no-arr") == (
        "text: '<string length: <200>>'\nnumbers: '<sequence type: length: 200>'\n---\n"
    )


def test_a_field_that_is_no_message_is_printed_as_it_is() -> None:
    assert echo("base") == "base\n---\n"
    assert echo(1.5) == "1.5\n---\n"
    assert echo((1, 2)) == "[1, 2]\n---\n"


def test_text_from_outside_does_no_harm_to_a_terminal() -> None:
    evil = "a\x1b[2J\u202eb"
    for shown in (echo(evil), echo({"a": evil}), echo({"a": evil}, "--csv")):
        assert "\x1b" not in shown
        assert "\u202e" not in shown
    assert "\x1b" not in as_json({"a": evil}, Limits())


def test_real_messages_are_printed_in_full() -> None:
    read_imu = decoder("sensor_msgs/msg/Imu", schema(Imu))
    shown = echo(read_imu(serialize(Imu())))
    assert shown.count("- 0.0\n") == 27
    assert shown.startswith("header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n")
    read_image = decoder("sensor_msgs/msg/Image", schema(Image))
    image = Image(height=1, width=300, step=300, encoding="mono8", data=bytes(300))
    assert as_csv(read_image(serialize(image)), Limits(2)).endswith("mo...,0,300,0,0,...")
    assert shortened(read_image(serialize(image)), Limits())["data"] == [0] * 300


def test_a_message_is_written_as_ros2_writes_the_call_of_its_class() -> None:
    shape = parsed({"type": "sensor_msgs/msg/Imu", "schema": schema(Imu)})
    read_imu = decoder("sensor_msgs/msg/Imu", schema(Imu))
    assert as_call(shape, read_imu(serialize(Imu()))).startswith(
        "sensor_msgs.msg.Imu(header=std_msgs.msg.Header("
        "stamp=builtin_interfaces.msg.Time(sec=0, nanosec=0), frame_id=''), "
        "orientation=geometry_msgs.msg.Quaternion("
    )


def window_of(numbers: list[float]) -> dict[str, Any]:
    """A report on these numbers, as programs make them."""
    return {
        "count": len(numbers),
        "seconds": 1.0,
        "min_ns": min(numbers),
        "max_ns": max(numbers),
        "mean_ns": statistics.fmean(numbers),
        "std_ns": statistics.pstdev(numbers),
    }


@given(st.lists(st.lists(st.floats(0, 1e6), min_size=1, max_size=5), min_size=1, max_size=5))
def test_reports_are_joined_as_if_they_were_one(parts: list[list[float]]) -> None:
    pool, numbers = Pool(1_000, "interval"), [number for part in parts for number in part]
    for part in parts:
        assert pool.add(window_of(part))  # type: ignore[arg-type]  # as JSON has it
    assert pool.count == len(numbers)
    assert (pool.least, pool.most) == (min(numbers), max(numbers))
    assert pool.mean == pytest.approx(statistics.fmean(numbers))
    assert pool.std == pytest.approx(statistics.pstdev(numbers), abs=1e-3)
    assert pool.seconds == len(parts)


def test_old_reports_leave_a_window_that_is_full() -> None:
    pool = Pool(4, "interval")
    for value in (1.0, 2.0, 3.0):
        pool.add(window_of([value] * 3))  # type: ignore[arg-type]  # as JSON has it
    assert (pool.count, pool.least) == (6, 2.0)
    assert not pool.add({"count": 0, "seconds": 1.0})
    assert pool.count == 6


def test_tables_are_aligned_and_harmless() -> None:
    rows = [("A", "B"), ("1", "long"), ("100", "x\x1b[2Jy")]
    assert columns(rows, right=(0,)) == "  A  B\n  1  long\n100  x\\x1b[2Jy"


def test_sizes_and_durations_are_short() -> None:
    assert [size(n) for n in (0, 999, 1000, 23_400_000, 5 * 10**12)] == [
        "0 B", "999 B", "1.0 kB", "23.4 MB", "5000.0 GB"
    ]  # fmt: skip
    assert size(None) == "-"
    hour = 3600
    shown = [duration(s * 10**9) for s in (0, 59, 60, 3599, hour, 23 * hour, 50 * hour + 60)]
    assert shown == ["0 s", "59 s", "1:00", "59:59", "01:00:00", "23:00:00", "2 d 02:01"]
    assert (milliseconds(None), milliseconds(1_234_567)) == ("-", "1.235 ms")
