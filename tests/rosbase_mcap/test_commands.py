"""`rosbase info`, `recover`, `cut` and `export` on files."""

from io import BytesIO
from pathlib import Path

import pytest

from rosbase.cli import main
from rosbase.contracts.message_format import message_format
from rosbase.messages import Header, Imu, PointStamped, Time, Vector3
from rosbase_mcap.channel_table import ORIGIN, OUTSIDE, ChannelTable
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.reading import messages
from rosbase_mcap.records import Kind
from rosbase_mcap.recovery import count_damaged
from rosbase_mcap.scanning import records_of
from support.open_chunks import open_chunk

S = 1_000_000_000


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A recording of two topics for four seconds."""
    table = ChannelTable()
    imu, point = message_format(Imu), message_format(PointStamped)
    numbers = (
        table.add("/imu/data", imu.type_name, imu.schema, {}),
        table.add("/point", point.type_name, point.schema, {}),
    )
    sink = FileSink(tmp_path / "run.mcap", table, {})
    for second in range(1, 5):
        header = Header(Time(second, 0), "imu_link")
        data = imu.encode(Imu(header, angular_velocity=Vector3(float(second))))
        sink.add(open_chunk(numbers[0], [second * S], data))
        sink.add(open_chunk(numbers[1], [second * S], point.encode(PointStamped(header))))
        sink.flush()
    sink.close()
    return tmp_path / "run.mcap"


def stamps(path: Path) -> list[tuple[str, int]]:
    with path.open("rb") as stream:
        return [(e.channel.topic, e.message.log_ns // S) for e in messages(stream)]


def test_info_names_topics_types_counts_and_times(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "messages:  8" in out
    assert "duration:  3.000 s" in out
    assert "start:     1970-01-01 00:00:01.000 UTC" in out
    assert "/imu/data  sensor_msgs/msg/Imu             4" in out
    assert "cut off" not in out


def test_info_tells_messages_from_outside_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, form = ChannelTable(), message_format(Imu)
    names = ("/imu", form.type_name, form.schema)
    channels = [table.add(*names, {}), table.add(*names, {ORIGIN: OUTSIDE})]
    sink = FileSink(tmp_path / "run.mcap", table, {})
    for channel in channels:
        sink.add(open_chunk(channel, [S], form.encode(Imu())))
    sink.close()
    assert main(["info", str(tmp_path / "run.mcap")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2:] == [
        "  /imu  sensor_msgs/msg/Imu  1",
        "  /imu  sensor_msgs/msg/Imu  1  from outside",
    ]


@pytest.mark.parametrize("command", ["info", "cut", "export"])
def test_a_folder_is_refused_and_its_files_are_named(
    command: str, path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = {"info": [], "cut": ["-o", str(tmp_path / "cut.mcap")], "export": ["--csv"]}[command]
    assert main([command, *more, str(tmp_path)]) == 2
    assert f"{tmp_path} is a folder: give a file in it: {path}" in capsys.readouterr().err
    path.unlink()
    assert main([command, *more, str(tmp_path)]) == 2
    assert "no MCAP file is in it" in capsys.readouterr().err


def test_info_reads_a_file_that_was_cut_off(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path.write_bytes(path.read_bytes()[:-40])
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "messages:  8" in out
    assert "rosbase recover" in out


def damaged(path: Path) -> Path:
    """Turns a bit in the second chunk of a recording."""
    with path.open("rb") as stream:
        chunks = [found for found in records_of(stream) if found.kind == Kind.CHUNK]
    data = bytearray(path.read_bytes())
    data[chunks[1].end - 1] ^= 1
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("words", [["info"], ["cut", "-o", "{}/cut.mcap"], ["export", "--csv"]])
def test_a_damaged_chunk_is_named(
    words: list[str], path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word.format(path.parent) for word in words]
    assert main([*words, str(path)]) == 0
    assert capsys.readouterr().err == ""
    for made in path.parent.glob("cut.mcap"):
        made.unlink()
    for made in path.parent.glob("run/*"):
        made.unlink()
    assert main([*words, str(damaged(path))]) == 0
    assert capsys.readouterr().err == f"{path}: 1 damaged chunk: messages are missing\n"


def test_zeros_within_a_file_are_damage_and_a_cut_is_none(path: Path) -> None:
    data = path.read_bytes()
    with path.open("rb") as stream:
        chunks = [found for found in records_of(stream) if found.kind == Kind.CHUNK]
    middle = chunks[1].offset
    assert count_damaged(BytesIO(data[: middle + 20])) == 0
    assert count_damaged(BytesIO(data[:middle] + bytes(16) + data[middle + 16 :])) == 1


def test_recover_mends_a_file_in_place(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = path.read_bytes()
    path.write_bytes(whole[:-40])
    assert main(["recover", str(path)]) == 0
    assert path.read_bytes() == whole
    assert main(["recover", str(path)]) == 0
    assert "nothing to mend" in capsys.readouterr().out
    assert [other.name for other in path.parent.iterdir()] == ["run.mcap"]


def test_recover_refuses_what_is_no_recording(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path.write_text("nothing of the kind")
    assert main(["recover", str(path)]) == 2
    assert "no MCAP file" in capsys.readouterr().err
    assert path.read_text() == "nothing of the kind"


def test_cut_keeps_topics_and_times(path: Path) -> None:
    target = path.with_name("part.mcap")
    options = ["--from", "1s", "--to", "1970-01-01T00:00:03"]
    assert main(["cut", str(path), "point", *options, "-o", str(target)]) == 0
    assert stamps(target) == [("/point", 2), ("/point", 3)]


def test_topics_may_stand_before_options_and_behind_them(path: Path) -> None:
    target = path.with_name("part.mcap")
    assert main(["cut", str(path), "point", "-o", str(target), "imu/data", "--to", "0s"]) == 0
    assert stamps(target) == [("/imu/data", 1), ("/point", 1)]


def test_cut_refuses_an_unknown_topic(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cut", str(path), "poin", "-o", str(path.with_name("part.mcap"))]) == 2
    assert "/imu/data, /point" in capsys.readouterr().err
    assert not path.with_name("part.mcap").exists()


def test_export_writes_a_table_for_each_topic(path: Path) -> None:
    assert main(["export", "--csv", str(path)]) == 0
    folder = path.with_suffix("")
    assert sorted(one.name for one in folder.iterdir()) == ["imu.data.csv", "point.csv"]
    lines = (folder / "imu.data.csv").read_text().splitlines()
    assert len(lines) == 5
    names, values = (line.split(",") for line in lines[:2])
    assert names[:4] == [
        "log_time_ns",
        "header.stamp.sec",
        "header.stamp.nanosec",
        "header.frame_id",
    ]
    assert values[:4] == ["1000000000", "1", "0", "imu_link"]


def test_export_overwrites_nothing(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "--csv", str(path)]) == 0
    assert main(["export", "--csv", str(path)]) == 2
    assert "there is such a file already" in capsys.readouterr().err
