"""The thread that writes, with disks that take everything, too little, or nothing."""

import errno
from collections.abc import Callable
from pathlib import Path

import pytest

from rosbase import make_logger
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.chunks import OpenChunk
from rosbase_mcap.file_sink import FACTS, FileSink
from rosbase_mcap.output_file import OutputFile
from rosbase_mcap.reading import contents, messages
from rosbase_mcap.recorder import LOSSES, Recorder
from rosbase_mcap.records import Attachment, Message, Metadata
from rosbase_mcap.recovery import is_complete
from rosbase_mcap.splitting import Split
from rosbase_mcap.traces import BROKEN
from support.open_chunks import messages_in, open_chunk
from support.waiting import wait_until

NO_METADATA: dict[str, str] = {}


class Listed:
    """A sink that keeps everything, or takes nothing."""

    def __init__(self, *, is_full: bool = False) -> None:
        self.messages: list[Message] = []
        self.notes: list[Metadata] = []
        self.attached: list[Attachment] = []
        self.ends: list[str] = []
        self.is_full = is_full

    def add(self, chunk: OpenChunk) -> None:
        if self.is_full:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.messages += messages_in([chunk])

    def head(self, make: Callable[[int], Metadata]) -> None:
        self.notes.append(make(0))

    def attach(self, attachment: Attachment) -> None:
        self.attached.append(attachment)

    def flush(self) -> None:
        pass

    def note(self, metadata: Metadata) -> None:
        self.notes.append(metadata)

    def close(self) -> None:
        self.ends.append("close")

    def abandon(self, reason: str) -> None:
        self.ends.append("abandon")


def test_what_was_recorded_before_the_stop_is_written() -> None:
    sink = Listed()
    recorder = Recorder(sink, ChannelTable(), make_logger("test"))
    record = recorder.channel("/a", "std_msgs/msg/String", "string data", NO_METADATA)
    recorder.start()
    for number in range(10):
        record(number, number, b"x")
    recorder.stop()
    assert [one[:3] for one in sink.messages] == [(0, number, number) for number in range(10)]
    assert sink.ends == ["close"]
    assert recorder.dropped == 0


def test_a_recording_that_was_never_started_has_an_end_too() -> None:
    sink = Listed()
    recorder = Recorder(sink, ChannelTable(), make_logger("test"))
    recorder.channel("/a", "std_msgs/msg/String", "string data", NO_METADATA)(-5, 1, b"x")
    recorder.stop()
    recorder.stop()
    assert sink.messages == [(0, 0, 0, 1, b"x")]
    assert sink.ends == ["close"]


def test_a_full_disk_ends_the_recording_with_one_line_and_the_program_goes_on(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sink = Listed(is_full=True)
    recorder = Recorder(sink, ChannelTable(), make_logger("test"))
    record = recorder.channel("/a", "std_msgs/msg/String", "string data", NO_METADATA)
    record(1, 1, b"x")
    recorder.start()
    wait_until(lambda: recorder.is_broken, "the end of the recording")
    for number in range(10):
        record(number, number, b"x")
    recorder.stop()
    assert sink.ends == ["abandon"]
    assert recorder.dropped == 11
    assert caplog.text.count("No space left") == 1


def test_a_mistake_of_ours_ends_the_recording_with_its_traceback(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Mistaken(Listed):
        def flush(self) -> None:
            raise ValueError("a mistake")

    recorder = Recorder(sink := Mistaken(), ChannelTable(), make_logger("test"))
    record = recorder.channel("/a", "std_msgs/msg/String", "string data", NO_METADATA)
    recorder.start()
    for number in range(10):
        record(number, number, b"x")
    recorder.stop()
    assert sink.ends == ["abandon"]
    assert recorder.dropped == 10
    assert caplog.text.count("the recording ends here, the program goes on: a mistake") == 1
    assert "Traceback" in caplog.text


def test_dropped_messages_are_counted_in_the_log_and_in_the_file(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sink = Listed()
    recorder = Recorder(sink, ChannelTable(), make_logger("test"), most_bytes=1000)
    record = recorder.channel("/a", "std_msgs/msg/String", "string data", NO_METADATA)
    for number in range(10):
        record(number, number, b"x" * 100)
    recorder.start()
    recorder.stop()
    assert recorder.dropped == 3
    assert sink.notes == [Metadata(LOSSES, {"messages": "3"})]
    assert "3 messages are missing" in caplog.text


def test_a_file_is_split_by_size_and_each_part_opens_by_itself(tmp_path: Path) -> None:
    table = ChannelTable()
    number = table.add("/a", "std_msgs/msg/String", "string data", {})
    sink = FileSink(tmp_path / "run.mcap", table, {"python": "3.11"}, split=Split(bytes=1500))
    for stamp in range(5):
        sink.add(open_chunk(number, [stamp], b"x" * 1000))
        sink.flush()
    sink.close()
    paths = sorted(tmp_path.iterdir())
    assert [path.name for path in paths] == ["run.mcap", "run_1.mcap", "run_2.mcap"]
    found = []
    for part, path in enumerate(paths):
        with path.open("rb") as stream:
            assert is_complete(stream)
            found += [entry.message.log_ns for entry in messages(stream)]
            notes = [one for one in contents(stream) if isinstance(one, Metadata)]
        assert notes == [Metadata(FACTS, {"python": "3.11", "part": str(part)})]
    assert found == [0, 1, 2, 3, 4]


def test_what_a_full_disk_has_taken_opens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = OutputFile.write

    def write(file: OutputFile, data: bytes | memoryview) -> None:
        if len(data) > 5000:
            file._file.write(data[:4000])
            raise OSError(errno.ENOSPC, "No space left on device")
        plain(file, data)

    monkeypatch.setattr(OutputFile, "write", write)
    table = ChannelTable()
    number = table.add("/a", "std_msgs/msg/String", "string data", {})
    sink = FileSink(tmp_path / "run.mcap", table, {})
    sink.add(open_chunk(number, [1], b"x" * 100))
    sink.flush()
    with pytest.raises(OSError, match="No space"):
        sink.add(open_chunk(number, [2], b"y" * 10_000))
    sink.abandon("the disk is full")
    with (tmp_path / "run.mcap").open("rb") as stream:
        assert Metadata(BROKEN, {"reason": "the disk is full"}) in contents(stream)
        assert is_complete(stream)
        assert [entry.message.log_ns for entry in messages(stream)] == [1]


def test_a_full_disk_without_room_for_the_end_costs_the_last_chunk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = OutputFile.write

    def write(file: OutputFile, data: bytes | memoryview) -> None:
        room = 60_000 - file.size_bytes
        if len(data) > room:
            file._file.write(data[:room])
            raise OSError(errno.ENOSPC, "No space left on device")
        plain(file, data)

    monkeypatch.setattr(OutputFile, "write", write)
    table = ChannelTable()
    number = table.add("/a", "std_msgs/msg/String", "string data", {})
    sink = FileSink(tmp_path / "run.mcap", table, {})
    for stamp in (1, 2, 3):
        # The third fills the disk up to some bytes.
        sink.add(open_chunk(number, [stamp], b"x" * (19_700 if stamp < 3 else 19_900)))
        sink.flush()
    with pytest.raises(OSError, match="No space"):
        sink.close()
    sink.abandon("the disk is full")
    with (tmp_path / "run.mcap").open("rb") as stream:
        assert Metadata(BROKEN, {"reason": "the disk is full"}) in contents(stream)
        assert is_complete(stream)
        assert [entry.message.log_ns for entry in messages(stream)] == [1, 2]


def test_a_recording_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_text("precious")
    with pytest.raises(FileExistsError):
        FileSink(path, ChannelTable(), {})
    assert path.read_text() == "precious"
