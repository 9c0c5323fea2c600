"""What has entered a program, and is replayed."""

from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import make_logger
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.entries import ENTRIES, Entry, EntryKind, attachment, entries_of
from rosbase_mcap.errors import McapError
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.reading import messages
from rosbase_mcap.recorder import Recorder

_ns = st.integers(0, 2**64 - 1)
bodies = st.lists(
    st.tuples(st.sampled_from(EntryKind), _ns, st.text(max_size=5), st.lists(_ns), st.binary()),
    max_size=8,
)


def file_with(*groups: list[Entry]) -> BytesIO:
    pieces: list[bytes] = []
    writer = FileWriter(pieces.append)
    for group in groups:
        writer.attach(attachment([entry.packed() for entry in group], 0))
    writer.finish()
    return BytesIO(b"".join(pieces))


@given(bodies, st.integers(0, 8))
def test_entries_are_read_as_they_were_written(
    found: list[tuple[EntryKind, int, str, list[int], bytes]], split: int
) -> None:
    entries = [Entry(number, *body) for number, body in enumerate(found)]
    stream = file_with(entries[:split], entries[split:])
    assert list(entries_of(stream)) == entries


def test_a_missing_entry_is_an_error_where_it_is_missing() -> None:
    stream = file_with([Entry(0, EntryKind.TICK, 1), Entry(3, EntryKind.TICK, 2)])
    found = entries_of(stream)
    assert next(found).number == 0
    with pytest.raises(McapError, match="entries 1 to 2 are missing"):
        next(found)


def test_an_entry_of_a_later_version_is_an_error() -> None:
    data = Entry(0, EntryKind.TICK, 1).packed()
    pieces: list[bytes] = []
    writer = FileWriter(pieces.append)
    writer.attach(attachment([data[:8] + b"\x63" + data[9:]], 0))
    writer.finish()
    with pytest.raises(McapError, match="unknown kind 99"):
        list(entries_of(BytesIO(b"".join(pieces))))


def test_entries_are_recorded_beside_the_messages(tmp_path: Path) -> None:
    path, table = tmp_path / "run.mcap", ChannelTable()
    recorder = Recorder(FileSink(path, table, {}), table, make_logger("test"))
    record = recorder.channel("/a", "std_msgs/msg/String", "string data", {})
    entries = [Entry(number, EntryKind.TICK, number, "loop", [number]) for number in range(3)]
    for entry in entries:
        recorder.enter(entry)
        record(entry.stamp_ns, entry.stamp_ns, b"x")
    recorder.start()
    recorder.stop()
    data = path.read_bytes()
    assert list(entries_of(BytesIO(data))) == entries
    assert len(list(messages(BytesIO(data)))) == 3
    assert ENTRIES.encode() in data
