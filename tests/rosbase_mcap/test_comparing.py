"""The first difference between two recordings."""

from io import BytesIO

from rosbase.contracts.message_format import message_format
from rosbase.messages import Imu, Vector3
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.comparing import Difference, first_difference
from rosbase_mcap.file_sink import write_items
from rosbase_mcap.file_writer import FileWriter

S = 1_000_000_000
FORM = message_format(Imu)
Line = tuple[str, int, float]


def recorded(*lines: Line) -> BytesIO:
    table, pieces = ChannelTable(), list[bytes]()
    writer = FileWriter(pieces.append)
    items = []
    for topic, second, rate in lines:
        number = table.add(topic, FORM.type_name, FORM.schema, {})
        data = FORM.encode(Imu(angular_velocity=Vector3(rate, 2.0, 3.0)))
        items.append((number, 0, second * S, second * S, data))
    write_items(writer, table, items)
    writer.finish()
    return BytesIO(b"".join(pieces))


def difference(before: list[Line], after: list[Line]) -> Difference | None:
    return first_difference(recorded(*before), recorded(*after), leave_out=["/left_out"])


ONE: list[Line] = [("/a", 1, 1.0), ("/b", 2, 2.0), ("/a", 3, 3.0)]


def test_the_same_messages_are_no_difference() -> None:
    assert difference(ONE, ONE) is None
    # However the channels are numbered, and whatever is on topics that may differ.
    assert difference(ONE, [("/left_out", 0, 1.0), *ONE]) is None


def test_a_value_that_differs_is_named_by_topic_time_and_field() -> None:
    found = difference(ONE, [*ONE[:2], ("/a", 3, 3.5)])
    assert found is not None
    assert (found.topic, found.log_ns, found.field) == ("/a", 3 * S, "angular_velocity.x")
    assert (found.before, found.after, found.number) == ("3.0", "3.5", 2)
    assert str(found).splitlines() == [
        "/a angular_velocity.x, after 2.000 s and 2 equal messages:",
        "  - 3.0",
        "  + 3.5",
    ]


def test_a_message_that_is_missing_or_too_many_is_named() -> None:
    missing = difference(ONE, ONE[:2])
    assert missing is not None
    assert (missing.before, missing.after) == (f"/a at {3 * S} ns", "nothing")
    more = difference(ONE[:2], ONE)
    assert more is not None
    assert (more.before, more.after) == ("nothing", f"/a at {3 * S} ns")


def test_another_order_is_a_difference() -> None:
    found = difference(ONE, [ONE[1], ONE[0], ONE[2]])
    assert found is not None
    assert (found.before, found.after) == (f"/a at {S} ns", f"/b at {2 * S} ns")


def test_another_time_is_a_difference() -> None:
    found = difference(ONE, [("/a", 1, 1.0), ("/b", 5, 2.0)])
    assert found is not None
    assert (found.field, found.after) == ("log time", f"{5 * S} ns")


def test_minus_zero_is_not_zero() -> None:
    found = difference([("/a", 1, 0.0)], [("/a", 1, -0.0)])
    assert found is not None
    assert (found.before, found.after) == ("0.0", "-0.0")
