"""Where a replay begins to differ from its recording."""

import math

import pytest

from rosbase.contracts.message_format import message_format
from rosbase.messages import Imu, JointState, Time, Vector3
from rosbase.messages.rcl_interfaces import Log
from rosbase_mcap.channel_table import ROS2MSG
from rosbase_mcap.outputs import Digest, Output
from rosbase_mcap.records import Schema
from rosbase_mcap.replaying.difference import Comparison, Difference, Flow, clock_text
from rosbase_mcap.replaying.fields import changes
from support.recorded_outputs import recorded_outputs

S = 1_000_000_000


def schema_of(msg_type: type) -> Schema:
    form = message_format(msg_type)
    return Schema(1, form.type_name, ROS2MSG, form.schema.encode())


def encoded(message: object) -> bytes:
    return message_format(type(message)).encode(message)


def imu(rate: float) -> bytes:
    return encoded(Imu(angular_velocity=Vector3(rate, 2.0, 3.0)))


def output(number: int, topic: str, rate: float) -> Output:
    return Output(number, topic, (100 + number) * S, imu(rate))


SCHEMAS = dict.fromkeys(("/a", "/b", "/c"), schema_of(Imu))
RUN = [output(1, "/a", 1.0), output(1, "/b", 2.0), output(3, "/a", 3.0), output(4, "/b", 4.0)]


def comparison(recorded: list[Output]) -> Comparison:
    outputs = recorded_outputs(recorded, SCHEMAS)
    found = Comparison(outputs, 100 * S, context=lambda: ("before: tick 7",))
    for topic, schema in SCHEMAS.items():
        found.declare(topic, schema)
    return found


def difference(recorded: list[Output], replayed: list[Output]) -> Difference | None:
    found = comparison(recorded)
    for one in replayed:
        found.hear(*one)
    return found.finish()


def test_the_same_outputs_are_no_difference() -> None:
    assert difference(RUN, RUN) is None
    # Dates are read from the recording, and are those of the machine.
    assert difference(RUN, [one._replace(log_ns=0) for one in RUN]) is None


def test_a_value_that_differs_is_named_by_topic_time_entry_and_field() -> None:
    found = difference(RUN, [*RUN[:2], output(3, "/a", 3.5), RUN[3]])
    assert found is not None
    assert (found.topic, found.number, found.since_ns, found.count) == ("/a", 3, 3 * S, 2)
    assert str(found).splitlines() == [
        "first difference at 00:03.000, entry 3, /a",
        "    angular_velocity.x: 3.0 -> 3.5   (recorded -> replayed)",
        "    15 other fields are equal",
        "before: tick 7",
    ]


def test_a_message_that_is_missing_is_named() -> None:
    in_the_middle = difference(RUN, [*RUN[:2], RUN[3]])
    assert in_the_middle is not None
    heading = "first difference at 00:03.000, entry 3, /a is not published any more"
    assert str(in_the_middle).splitlines()[0] == heading
    at_the_end = difference(RUN, RUN[:3])
    assert at_the_end is not None
    assert (at_the_end.topic, at_the_end.number) == ("/b", 4)


def test_a_replay_that_was_ended_before_misses_nothing() -> None:
    for number, is_missing in ((3, False), (4, True)):
        found = comparison(RUN)
        for one in RUN[:3]:
            found.hear(*one)
        assert (found.finish(number) is not None) == is_missing


def test_a_replay_of_another_flow_that_was_ended_before_misses_nothing() -> None:
    found = comparison(RUN)
    for one in RUN[:3]:
        found.hear(*one)
    found.differ_in_flow(Flow("timer 3 is gone", 3, 3 * S))
    first = found.finish(number=9, end_ns=RUN[3].log_ns - 1)
    assert first is not None
    assert first.topic == ""


def test_a_message_that_is_new_is_named() -> None:
    new = difference(RUN, [*RUN[:2], output(2, "/c", 0.0), *RUN[2:]])
    assert new is not None
    assert str(new).splitlines()[0] == "first difference at 00:02.000, entry 2, /c is new"
    at_the_end = difference(RUN, [*RUN, output(9, "/a", 0.0)])
    assert at_the_end is not None
    assert "/a is new" in str(at_the_end)


def test_another_order_within_an_entry_is_a_difference() -> None:
    found = difference(RUN, [RUN[1], RUN[0], *RUN[2:]])
    assert found is not None
    expected = "entry 1, /a is not published any more; /b comes instead"
    assert str(found).splitlines()[0].endswith(expected)


def test_numbers_that_have_reached_32_bits_are_ordered() -> None:
    last = [output(2**32 - 1, "/a", 1.0), output(0, "/b", 1.0)]
    found = difference(last, last[1:])
    assert found is not None
    assert (found.topic, found.kind.value) == ("/a", "is not published any more")


def test_after_another_flow_messages_are_compared_by_topic() -> None:
    found = comparison(RUN)
    found.hear(*RUN[0])
    found.differ_in_flow(Flow("timer 3 is gone", 2, 2 * S, ("before: tick 6",)))
    for one in (output(7, "/a", 3.0), output(8, "/b", 2.0), output(9, "/b", 4.5)):
        found.hear(*one)
    first = found.finish()
    assert first is not None
    assert (first.topic, first.since_ns) == ("/b", 4 * S)
    assert str(first).splitlines() == [
        "first difference at 00:02.000, entry 2: timer 3 is gone",
        "before: tick 6",
        "then, at 00:04.000, /b",
        "    angular_velocity.x: 4.0 -> 4.5   (recorded -> replayed)",
        "    15 other fields are equal",
    ]


def test_another_flow_with_the_same_messages_is_a_difference() -> None:
    found = comparison(RUN)
    for number, one in enumerate(RUN):
        found.hear(*one._replace(number=one.number + number))
        found.differ_in_flow(Flow(f"timer {number} is gone", 2 + number, (2 + number) * S))
    first = found.finish()
    assert first is not None
    assert str(first).splitlines()[0] == "first difference at 00:02.000, entry 2: timer 0 is gone"


def test_after_another_flow_a_silent_topic_is_named_and_kept_within_limits() -> None:
    many = [output(1, "/a", 1.0)] + [output(number, "/b", 0.0) for number in range(2, 5000)]
    found = comparison([*many, output(5000, "/a", 2.0)])
    found.differ_in_flow(Flow("other", 0, 0))
    found.hear(*output(1, "/a", 1.0))
    found.hear(*output(2, "/a", 2.0))
    assert found.difference is not None
    assert (found.difference.topic, found.difference.number) == ("/b", 2)


def test_minus_zero_is_not_zero_and_nan_is_nan() -> None:
    schemas = schema_of(Imu), schema_of(Imu)
    [zero] = changes(imu(0.0), imu(-0.0), *schemas).fields
    assert (zero.before, zero.after) == ("0.0", "-0.0")
    one, other = (imu(math.nan)[:-1] + end for end in (b"\x00", b"\x80"))
    [last] = changes(one, other, *schemas).fields
    assert last.field.startswith("linear_acceleration_covariance")


def test_elements_of_arrays_are_named() -> None:
    schemas = schema_of(JointState), schema_of(JointState)
    names = ("a", "b")
    one = JointState(name=names, position=(1.0, 2.0), velocity=(0.5,) * 40)
    other = JointState(name=names, position=(1.0, 2.5), velocity=(0.25,) * 40)
    found = changes(encoded(one), encoded(other), *schemas)
    assert str(found.fields[0]) == "position[1]: 2.0 -> 2.5"
    assert [change.field for change in found.fields[1:]] == [f"velocity[{at}]" for at in range(10)]
    shorter = changes(encoded(one), encoded(JointState(name=names)), *schemas)
    assert str(shorter.fields[0]) == "position: 2 elements -> 0 elements"


def test_another_type_or_an_unknown_one_is_shown() -> None:
    [kind] = changes(b"a", b"b", schema_of(Imu), schema_of(JointState)).fields
    assert str(kind) == "type: sensor_msgs/msg/Imu -> sensor_msgs/msg/JointState"
    [unknown] = changes(b"same\x00", b"same\x01\x02", None, None).fields
    assert str(unknown) == "byte 4: 00 -> 01 02"
    [broken] = changes(b"same\x00", b"same", schema_of(Imu), schema_of(Imu)).fields
    assert str(broken) == "byte 4: 00 -> nothing"


def log_line(text: str, line: int = 1, name: str = "robot") -> bytes:
    return encoded(Log(Time(5, 6), Log.ERROR, name, text, "a.py", "f", line))


@pytest.mark.parametrize(
    ("recorded", "replayed"),
    [
        (log_line("done", line=1), log_line("done", line=2)),
        (log_line("<Gait object at 0x7f3ab0>"), log_line("<Gait object at 0x7f3ac0>")),
        (
            log_line("it failed\nTraceback (most recent call last):\n  a, line 1"),
            log_line("it failed\nTraceback (most recent call last):\n  a, line 2"),
        ),
    ],
)
def test_a_line_of_the_log_may_differ_in_place_addresses_and_traceback(
    recorded: bytes, replayed: bytes
) -> None:
    schemas = schema_of(Log), schema_of(Log)
    assert changes(recorded, replayed, *schemas).fields == ()
    runs = [[Output(1, "/rosout", S, data)] for data in (recorded, replayed)]
    found = Comparison(recorded_outputs(runs[0], {"/rosout": schemas[0]}), 0)
    found.declare("/rosout", schemas[0])
    found.hear(*runs[1][0])
    assert found.finish() is None


def test_a_line_of_the_log_with_another_text_is_a_difference() -> None:
    schemas = schema_of(Log), schema_of(Log)
    [text] = changes(log_line("height 1.0"), log_line("height 1.5"), *schemas).fields
    assert str(text) == "msg: 'height 1.0' -> 'height 1.5'"


@pytest.mark.parametrize("text", ["status 0x{}", "register at 0x{:.4}", "at 0x{}", "0x{}>"])
def test_a_hexadecimal_number_in_the_log_is_compared(text: str) -> None:
    schemas = schema_of(Log), schema_of(Log)
    before, after = log_line(text.format("7f3ab0c1")), log_line(text.format("8f3ab0c2"))
    assert changes(before, after, *schemas).fields


def digest(*outputs: Output) -> str:
    found = Digest()
    for one in outputs:
        found.add(one.number, one.topic, one.data)
    return found.hexdigest


def test_the_digest_counts_numbers_topics_bytes_and_order() -> None:
    whole = digest(*RUN)
    assert whole == digest(*[one._replace(log_ns=0) for one in RUN])
    assert whole == digest(*RUN, Output(9, "/rosout", 0, b"a line"))
    assert whole == digest(*[one._replace(number=one.number + 2**32) for one in RUN])
    others = [
        digest(*RUN[1:]),
        digest(RUN[1], RUN[0], *RUN[2:]),
        digest(RUN[0]._replace(number=2), *RUN[1:]),
        digest(RUN[0]._replace(topic="/c"), *RUN[1:]),
        digest(RUN[0]._replace(data=b""), *RUN[1:]),
        digest(Output(1, "/ab", 0, b"c")),
        digest(Output(1, "/a", 0, b"bc")),
    ]
    assert len({whole, *others}) == 8


def test_times_are_shown_as_on_a_clock() -> None:
    assert clock_text(12_345_678_901) == "00:12.345"
    assert clock_text(3_725_000_000_000) == "1:02:05.000"
