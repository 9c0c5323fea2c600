"""What a program has published is stepped over as bytes, or read, with the same result."""

from io import BytesIO

from hypothesis import given
from hypothesis import strategies as st

from rosbase_mcap.channel_table import ROS2MSG
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.outputs import Output
from rosbase_mcap.reading import chunk_records
from rosbase_mcap.records import Channel, Kind, Schema, record
from rosbase_mcap.replaying.recorded_outputs import RecordedOutputs
from support.recorded_outputs import chunk, declarations

SCHEMA = Schema(1, "std_msgs/msg/String", ROS2MSG, b"string data")
INSIDE = {"/a": SCHEMA, "/b": SCHEMA}
OUTSIDE = ["/a", "/c"]
# By channel: two topics from within, and two from outside, of which one has the same name.
TOPICS = ["/a", "/b", "/a from outside", "/c"]
OUTPUT = st.builds(
    Output,
    st.integers(0, 3) | st.just(2**32 - 1),
    st.sampled_from(TOPICS),
    st.integers(0, 2**63),
    # Some look like the head of another message.
    st.sampled_from([b"", b"x", b"\x05" + bytes(30), b"y" * 300]) | st.binary(max_size=40),
)
CHUNKS = st.lists(st.lists(OUTPUT, max_size=8), max_size=4)


def read(chunks: list[list[Output]], *more: bytes) -> RecordedOutputs:
    head = declarations(INSIDE, OUTSIDE)
    return RecordedOutputs([[head, *(chunk(one, TOPICS) for one in chunks), *more]])


def from_within(chunks: list[list[Output]]) -> list[Output]:
    return [one for several in chunks for one in several if one.topic in INSIDE]


@given(CHUNKS)
def test_what_came_from_within_is_read_in_its_order(chunks: list[list[Output]]) -> None:
    found = read(chunks)
    assert list(found) == from_within(chunks)
    assert found.schemas == INSIDE
    assert next(found, None) is None


@given(CHUNKS, st.data())
def test_a_repeated_output_is_stepped_over_and_no_other(
    chunks: list[list[Output]], data: st.DataObject
) -> None:
    found = read(chunks)
    for one in from_within(chunks):
        other = data.draw(OUTPUT.filter(lambda new: new.topic in INSIDE))
        if (other.number, other.topic, other.data) != (one.number, one.topic, one.data):
            assert not found.repeats(other.number, other.topic, other.data)
        # It may leave an output to `next`, but steps over none that it has not compared.
        if not found.repeats(one.number, one.topic, one.data):
            assert next(found) == one
    assert next(found, None) is None


def test_outputs_that_follow_each_other_are_repeated_without_being_read() -> None:
    run = [Output(number, ("/a", "/b")[number % 2], 7, b"%d" % number) for number in range(9)]
    found = read([run[:4], run[4:]])
    # The dates are those of the machine.
    assert all(found.repeats(one.number, one.topic, one.data) for one in run)
    assert not found.repeats(0, "/a", b"")
    assert next(found, None) is None


def test_a_topic_that_the_recording_does_not_have_is_not_repeated() -> None:
    one = Output(1, "/a", 7, b"x")
    found = read([[one]])
    assert not found.repeats(1, "/new", b"x")
    assert not found.repeats(1, "/c", b"x")
    assert next(found) == one


def test_each_file_has_channels_of_its_own() -> None:
    one, other = Output(1, "/a", 7, b"x"), Output(2, "/b", 8, b"x")
    swapped = dict(reversed(INSIDE.items()))
    files = [
        [declarations(INSIDE), chunk([one], list(INSIDE))],
        [declarations(swapped), chunk([other], list(swapped))],
    ]
    assert list(RecordedOutputs(files)) == [one, other]
    found = RecordedOutputs(files)
    assert found.repeats(1, "/a", b"x")
    assert not found.repeats(2, "/a", b"x")
    assert found.repeats(2, "/b", b"x")


def test_what_is_damaged_or_cut_off_is_left_out() -> None:
    one, other = Output(1, "/a", 7, b"x"), Output(2, "/b", 8, b"yz")
    short_message, unknown = record(Kind.MESSAGE, b"short"), record(Kind.METADATA, b"")
    whole = chunk([other], TOPICS)
    for cut in range(len(whole)):
        damaged = short_message + unknown + chunk([one], TOPICS) + whole[:cut]
        found = read([], damaged, whole)
        assert list(found) == [one, other]


def test_the_records_of_a_file_are_those_of_its_chunks_and_topics() -> None:
    pieces = list[bytes | memoryview]()
    writer = FileWriter(pieces.append)
    writer.declare(Channel(0, 1, "/a", "cdr"), SCHEMA)
    for number in range(3):
        writer.add(0, number, 7, 7, b"x")
        writer.end_chunk()
    writer.finish()
    found = RecordedOutputs([chunk_records(BytesIO(b"".join(pieces)))])
    assert list(found) == [Output(number, "/a", 7, b"x") for number in range(3)]
