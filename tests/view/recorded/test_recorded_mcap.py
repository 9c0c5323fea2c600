"""Recordings in MCAP files that another library has written, as the views read them."""

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import CompressionType, IndexType, Writer

from rosbase import ConfigurationError, RosbaseError
from rosbase.messages import Imu, String
from rosbase.wire import schema
from rosbase_mcap.reading import read_summary
from rosbase_view.recorded.mcap_file import McapFile
from rosbase_view.sources import open_source
from support.command import ROSBASE, run_rosbase
from support.foxglove_client import FoxgloveClient
from support.foxglove_served import served
from support.launching import has_tmux, own_tmux
from support.made_recording import BEGIN_NS, STEP_NS, MadeRecording, number_of
from support.waiting import wait_until

COUNT = 1_000
KINDS: dict[str, dict[str, Any]] = {
    "lz4": {"compression": CompressionType.LZ4},
    "zstd": {"compression": CompressionType.ZSTD},
    "none": {"compression": CompressionType.NONE},
    "unchunked": {"use_chunking": False},
    "unindexed": {"index_types": IndexType.NONE},
    "chunks indexed": {"index_types": IndexType.CHUNK},
}


def write(path: Path, **options: Any) -> Path:
    """Writes a recording in small chunks; its messages are not quite in order."""
    made = MadeRecording(COUNT)
    messages = list(made.messages(BEGIN_NS))
    for place in range(100, COUNT - 1, 100):
        messages[place], messages[place + 1] = messages[place + 1], messages[place]
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=10_000, **options)
        writer.start("ros2", "test")
        channels = {}
        for topic in made.topics:
            number = writer.register_schema(topic.type, "ros2msg", topic.schema.encode())
            channels[topic.name] = writer.register_channel(topic.name, "cdr", number)
        other = writer.register_schema("Thing", "jsonschema", b"{}")
        thing = writer.register_channel("/thing", "json", other)
        writer.add_message(thing, BEGIN_NS, b"{}", BEGIN_NS)
        for one in messages:
            writer.add_message(channels[one.topic], one.stamp_ns, one.data, one.stamp_ns)
        writer.finish()
    return path


@contextmanager
def opened(path: Path) -> Iterator[McapFile]:
    recording = McapFile(path)
    try:
        yield recording
    finally:
        recording.close()


@pytest.fixture(params=KINDS)
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    return write(tmp_path / "run.mcap", **KINDS[request.param])


def numbers(messages: Any) -> list[int]:
    return [number_of(one.data) for one in messages if one.topic == "/imu/data"]


def test_all_messages_are_read_in_the_order_of_time(path: Path) -> None:
    with path.open("rb") as stream:
        summary = read_summary(stream)
        is_chunked = summary is not None and bool(summary.chunks)
    with opened(path) as found:
        assert {(one.name, one.type, one.schema) for one in found.topics} == {
            ("/imu/data", "sensor_msgs/msg/Imu", schema(Imu)),
            ("/model", "std_msgs/msg/String", schema(String)),
        }
        assert (found.begin_ns, found.end_ns) == (BEGIN_NS, BEGIN_NS + (COUNT - 1) * STEP_NS)
        read = numbers(found.messages(0))
        assert sorted(read) == list(range(COUNT))
        # Whatever was written late comes late, but for those of one chunk.
        assert sum(a > b for a, b in pairwise(read)) <= (3 if is_chunked else 9)


@pytest.mark.parametrize("start", [0, 1, 99, 101, 500, COUNT - 1])
def test_a_part_is_read_from_any_time_on(path: Path, start: int) -> None:
    with opened(path) as found:
        at_ns = BEGIN_NS + start * STEP_NS
        assert sorted(numbers(found.messages(at_ns))) == list(range(start, COUNT))
        latest = {one.topic: one for one in found.latest(at_ns)}
        if start == 0:
            assert not latest
        else:
            assert number_of(latest["/imu/data"].data) == start - 1
            # It came once, at the very beginning.
            assert latest["/model"].stamp_ns == BEGIN_NS


def test_a_search_for_the_last_messages_does_not_disturb_reading(path: Path) -> None:
    with opened(path) as found:
        messages = found.messages(0)
        read = [next(messages) for _ in range(300)]
        found.latest(BEGIN_NS + 900 * STEP_NS)
        read += messages
        assert sorted(numbers(read)) == list(range(COUNT))


@pytest.mark.parametrize("kind", ["lz4", "none"])
def test_a_file_that_was_cut_off_is_mended(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / "cut.mcap", **KINDS[kind])
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with opened(path) as found:
        read = sorted(numbers(found.messages(0)))
        assert 300 < len(read) < COUNT
        assert read == list(range(len(read)))
    assert path.stat().st_size == len(data) // 2


def test_mending_is_told_because_it_may_take_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "cut.mcap", **KINDS["lz4"])
    open_source(str(path)).close()
    assert capsys.readouterr().err == ""
    path.write_bytes(path.read_bytes()[:-100])
    open_source(str(path)).close()
    assert capsys.readouterr().err == f"rosbase view: {path} was cut off; a copy is mended ...\n"


def test_what_is_no_recording_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="No such file"):
        McapFile(tmp_path / "nothing.mcap")
    (tmp_path / "text.mcap").write_text("no recording" * 100)
    with pytest.raises(RosbaseError, match="no MCAP file"):
        McapFile(tmp_path / "text.mcap")
    with (tmp_path / "empty.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "test")
        writer.finish()
    with pytest.raises(ConfigurationError, match="no messages of ROS 2"):
        McapFile(tmp_path / "empty.mcap")
    done = run_rosbase("view", "--foxglove", "0", str(tmp_path / "text.mcap"))
    assert done.returncode in (1, 2)
    assert done.stderr.count("\n") == 1, done.stderr


def test_the_command_plays_a_file_to_foxglove(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", compression=CompressionType.LZ4)
    with served(str(path)) as (_, port), FoxgloveClient(port) as client:
        client.subscribe("/imu/data")
        client.control(plays=True, speed=20.0)
        client.until(lambda: len(client.of("/imu/data")) >= COUNT, "all messages")
        assert sorted(numbers(client.of("/imu/data"))) == list(range(COUNT))


@pytest.mark.skipif(not has_tmux(), reason="tmux is not installed")
def test_the_command_plays_a_file_in_the_terminal(tmp_path: Path) -> None:
    path = write(tmp_path / "day.mcap")
    with own_tmux(tmp_path) as tmux:

        def shows(part: str) -> bool:
            return part in tmux("capture-pane", "-p", "-t", "view")

        command = shlex.join([ROSBASE, "view", str(path)])
        tmux(
            "new-session", "-d", "-s", "view", "-x", "80", "-y", "24", "-e", "PYTHONUTF8=1", command
        )
        wait_until(lambda: shows(" playing  0:0"), "the time line")
        wait_until(lambda: shows("▶ /imu/data"), "the topics")
        wait_until(lambda: shows("roll"), "a message")
        tmux("send-keys", "-t", "view", "Space")
        wait_until(lambda: shows(" paused "), "the pause")
        tmux("send-keys", "-t", "view", "q")
        wait_until(lambda: not tmux("list-sessions"), "the end of the view")
