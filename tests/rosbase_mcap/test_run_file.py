"""A recorded run, as a replay reads it: its trace and its outputs, in one file or several."""

from io import BytesIO
from pathlib import Path

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from rosbase.cli import main
from rosbase.entries.kinds import Kind
from rosbase.entries.script import read_entries
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace, TraceBlock
from rosbase_mcap.channel_table import ORIGIN, OUTSIDE
from rosbase_mcap.errors import McapError, NotMcapError
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.outputs import Output
from rosbase_mcap.reading import contents
from rosbase_mcap.records import Attachment, Channel, Message, Metadata, Schema
from rosbase_mcap.recovery import mend
from rosbase_mcap.replaying.run_file import open_run
from rosbase_mcap.traces import (
    END,
    Run,
    RunEnd,
    blocks_of,
    end_metadata,
    read_end,
    read_run,
    run_metadata,
    trace_attachment,
)

S = 1_000_000_000
START = 1_700_000_000 * S
RUN = Run("abc", 0, "start", frozenset(), RunFacts(START, 5, {"argv": ["a", "b c"], "seed": 7}))
RUN_END = RunEnd(EndFacts(9, "", ("a timer of a thread",)), {"node": "robot"})
SCHEMA = Schema(1, "std_msgs/msg/String", "ros2msg", b"string data")
INSIDE = Channel(0, 1, "/a", "cdr")
FROM_OUTSIDE = Channel(1, 1, "/b", "cdr", {ORIGIN: OUTSIDE})
SECONDS = 4


def trace() -> list[TraceBlock]:
    """A run with a tick each second, and a block for each."""
    notes, blocks = Trace(), []
    notes.begin(Kind.BEGIN, 0)
    for second in range(SECONDS):
        notes.begin(Kind.TICK, second * S, 0, 0)
        notes.note(Kind.READ_DATE, 1)
        notes.begin(Kind.LOOK, second * S)
        blocks.append(notes.take())
    notes.begin(Kind.END, SECONDS * S)
    return [*blocks, notes.take()]


def output(number: int) -> Output:
    return Output(number, "/a", START + number * S, b"%d" % number)


def run_file(run: Run, numbers: range, end: RunEnd | None = None) -> bytes:
    """A file with a chunk and a block of the trace for each of these numbers."""
    pieces = list[bytes | memoryview]()
    writer = FileWriter(pieces.append)
    writer.note(Metadata("rosbase", {}))
    writer.note(run_metadata(run))
    for channel in (INSIDE, FROM_OUTSIDE):
        writer.declare(channel, SCHEMA)
    for number in numbers:
        one = output(number)
        writer.add(0, one.number, one.log_ns, one.log_ns, one.data)
        writer.add(1, one.number, one.log_ns, one.log_ns, b"from outside")
        writer.end_chunk()
        writer.attach(trace_attachment(trace()[number], number, START))
    if end is not None:
        writer.note(end_metadata(end))
    writer.finish()
    return b"".join(pieces)


ALL = range(SECONDS + 1)
WHOLE = run_file(RUN, ALL, RUN_END)


def test_facts_of_a_run_come_back_equal() -> None:
    assert read_run(run_metadata(RUN)) == RUN
    chosen = evolve(RUN, part=3, begins="ring", topics=frozenset(["/a", "/b"]))
    assert read_run(run_metadata(chosen)) == chosen
    assert read_end(end_metadata(RUN_END)) == RUN_END


def test_facts_that_are_damaged_or_of_later_versions_are_refused() -> None:
    good = run_metadata(RUN)
    for key, value in (("format", "2"), ("part", "x"), ("start_date_ns", '"x"'), ("run", None)):
        values = {**good.values, key: value}
        bad = Metadata(good.name, {k: v for k, v in values.items() if v is not None})
        with pytest.raises(McapError, match=r"later version|damaged"):
            read_run(bad)
    with pytest.raises(McapError, match="damaged"):
        read_end(Metadata(END, {"entries": "1"}))


def test_a_missing_part_is_named(tmp_path: Path) -> None:
    for part in range(3):
        end = RUN_END if part == 2 else None
        name = f"run_{part}.mcap" if part else "run.mcap"
        made = run_file(evolve(RUN, part=part), range(part, part + 1), end)
        (tmp_path / name).write_bytes(made)

    def no_end() -> str:
        found = open_run(tmp_path / "run.mcap")
        assert found is not None
        return found.no_end

    assert no_end() == ""
    (tmp_path / "run_1.mcap").rename(tmp_path / "other.mcap")
    assert no_end() == "the recording has no end: run_1.mcap is missing"
    (tmp_path / "run_2.mcap").unlink()
    assert no_end() == (
        "the recording has no end: its program was killed, the disk was full, "
        "or run_1.mcap is missing"
    )
    (tmp_path / "run.mcap").write_bytes((tmp_path / "run.mcap").read_bytes()[:-20])
    assert no_end() == "the recording has no end: its program was killed, or the disk was full"


def test_a_block_is_an_attachment_with_the_date_of_its_first_entry() -> None:
    attachment = trace_attachment(trace()[2], 42, START)
    assert attachment.name == "rosbase/trace/000042"
    assert attachment.log_ns == START + 2 * S


def test_a_run_is_read_with_its_trace_and_what_came_from_within(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(WHOLE)
    found = open_run(path)
    assert found is not None
    assert (found.run, found.end, found.paths, found.lost) == (RUN, RUN_END, [path], 0)
    assert list(found.blocks()) == trace()
    outputs = found.outputs()
    assert list(outputs) == [output(number) for number in ALL]
    assert outputs.schemas == {"/a": SCHEMA}


def test_messages_that_were_dropped_are_counted(tmp_path: Path) -> None:
    pieces = list[bytes | memoryview]()
    writer = FileWriter(pieces.append)
    writer.note(run_metadata(RUN))
    writer.note(Metadata("rosbase_dropped", {"messages": "12"}))
    writer.finish()
    path = tmp_path / "run.mcap"
    path.write_bytes(b"".join(pieces))
    found = open_run(path)
    assert found is not None
    assert found.lost == 12


@given(st.integers(0, len(WHOLE)))
def test_a_file_that_was_cut_off_has_a_prefix_of_the_trace_and_all_outputs_of_it(cut: int) -> None:
    stream = BytesIO(WHOLE[:cut])
    try:
        found = list(contents(stream))
    except NotMcapError:
        return
    blocks = list(blocks_of(one for one in found if isinstance(one, Attachment)))
    assert blocks == trace()[: len(blocks)]
    # Each block stands behind the messages of its entries.
    numbers = {one.sequence for one in found if isinstance(one, Message)}
    assert numbers >= set(range(len(blocks)))
    mended = list[bytes | memoryview]()
    mend(stream, mended.append)
    again = contents(BytesIO(b"".join(mended)))
    assert list(blocks_of(one for one in again if isinstance(one, Attachment))) == blocks


def test_a_trace_ends_where_a_block_is_missing_or_damaged() -> None:
    attachments = [trace_attachment(block, at, START) for at, block in enumerate(trace())]
    assert list(blocks_of([*attachments[:2], *attachments[3:]])) == trace()[:2]
    damaged = evolve(attachments[1], data=attachments[1].data[:-3] + b"abc")
    assert list(blocks_of([attachments[0], damaged, *attachments[2:]])) == trace()[:1]
    assert list(blocks_of([evolve(attachments[0], name="photo.jpg"), *attachments])) == trace()


def test_parts_are_read_as_one(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(run_file(RUN, range(2)))
    (tmp_path / "run_1.mcap").write_bytes(run_file(evolve(RUN, part=1), range(2, 3)))
    (tmp_path / "run_2.mcap").write_bytes(run_file(evolve(RUN, part=2), range(3, 5), RUN_END))
    found = open_run(path)
    assert found is not None
    assert len(found.paths) == 3
    assert found.end == RUN_END
    assert list(found.blocks()) == trace()
    assert list(found.outputs()) == [output(number) for number in ALL]
    # The end of the trace is missing if the last file is.
    (tmp_path / "run_2.mcap").unlink()
    found = open_run(path)
    assert found is not None
    assert found.end is None
    assert len(list(read_entries(found.blocks()))) == 6


def test_a_file_of_another_run_is_no_part(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(run_file(RUN, range(2)))
    for other in (evolve(RUN, id="other", part=1), evolve(RUN, part=2)):
        (tmp_path / "run_1.mcap").write_bytes(run_file(other, range(2, 5), RUN_END))
        found = open_run(path)
        assert found is not None
        assert found.paths == [path]


def test_a_later_part_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run_1.mcap"
    path.write_bytes(run_file(evolve(RUN, part=1), range(2)))
    with pytest.raises(McapError, match="is file 2 of a recording"):
        open_run(path)


def test_a_recording_without_a_trace_is_no_run(tmp_path: Path) -> None:
    pieces = list[bytes | memoryview]()
    writer = FileWriter(pieces.append)
    writer.declare(INSIDE, SCHEMA)
    writer.add(0, 0, 1, 1, b"")
    writer.finish()
    path = tmp_path / "run.mcap"
    path.write_bytes(b"".join(pieces))
    assert open_run(path) is None


def test_a_part_that_was_cut_out_has_topics_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, part = tmp_path / "run.mcap", tmp_path / "part.mcap"
    path.write_bytes(WHOLE)
    assert main(["info", str(path)]) == 0
    assert "replay:    all inputs" in capsys.readouterr().out
    assert main(["cut", str(path), "/a", "-o", str(part)]) == 0
    assert open_run(part) is None
    assert main(["info", str(part)]) == 0
    lines = capsys.readouterr().out
    assert "replay:    topics only" in lines
    assert "attached" not in lines
