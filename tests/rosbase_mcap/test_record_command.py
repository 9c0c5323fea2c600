"""`rosbase record` of a program that runs."""

import signal
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import pytest

from rosbase import RecordOptions
from rosbase.messages.rcl_interfaces import ParameterEvent
from rosbase.roles.recording import RECORD_VARIABLE
from rosbase.wire import deserialize
from rosbase_mcap.reading import messages, read_summary
from rosbase_mcap.recovery import is_complete, mend
from support.operated import APP, Robots, pid_of, robots_in, run, run_both
from support.waiting import wait_until


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as made:
        yield made


def test_the_topics_of_a_running_program_are_recorded(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    pid = str(pid_of(robots.start(APP)))
    out = run("record", pid, "-o", str(path), "--duration", "1s")
    assert str(path) in out
    with path.open("rb") as stream:
        assert is_complete(stream)
        summary = read_summary(stream)
        assert summary is not None
        topics = {channel.topic for channel in summary.channels.values()}
        found = [
            entry.message.log_ns for entry in messages(stream) if entry.channel.topic == "/position"
        ]
    assert f"{summary.messages} messages" in out
    # The log of the program is there too: it has said something before.
    assert "/position" in topics
    assert found == sorted(found)


def test_the_recording_ends_in_order_when_the_program_ends(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    program = robots.start(APP)
    recording = robots.start_command("record", "app", "-o", str(path), "position")
    wait_until(lambda: path.exists() and path.stat().st_size > 2_000, "messages in the file")
    program.process.send_signal(signal.SIGINT)
    out, err = recording.communicate(timeout=30)
    assert recording.returncode == 0, err
    assert "messages" in out
    assert is_complete(BytesIO(path.read_bytes()))


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_recording_in_order(
    robots: Robots, tmp_path: Path, signum: signal.Signals
) -> None:
    path = tmp_path / "app.mcap"
    robots.start(APP)
    recording = robots.start_command("record", "app", "-o", str(path), "position")
    wait_until(lambda: path.exists() and path.stat().st_size > 2_000, "messages in the file")
    recording.send_signal(signum)
    _, err = recording.communicate(timeout=30)
    assert recording.returncode == 0, err
    assert is_complete(BytesIO(path.read_bytes()))


def test_the_last_seconds_are_written_at_the_end(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    robots.start(APP)
    run("record", "app", "-o", str(path), "--last", "0.5s", "--duration", "2s", "position")
    with path.open("rb") as stream:
        assert is_complete(stream)
        found = [entry.message.log_ns for entry in messages(stream)]
    assert 0 < found[-1] - found[0] <= 500_000_000


def test_a_recording_that_is_killed_is_mended(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    robots.start(APP)
    recording = robots.start_command("record", "app", "-o", str(path), "position")
    wait_until(lambda: path.exists() and path.stat().st_size > 2_000, "messages in the file")
    recording.kill()
    recording.wait()
    data = path.read_bytes()
    assert not is_complete(BytesIO(data))
    pieces: list[bytes | memoryview] = []
    outcome = mend(BytesIO(data), pieces.append)
    assert outcome.summary.messages > 0
    assert is_complete(BytesIO(b"".join(pieces)))


@pytest.mark.parametrize("option", ["--split-size", "--split-time", "--last"])
def test_a_limit_of_nothing_is_refused(option: str, tmp_path: Path) -> None:
    path = str(tmp_path / "app.mcap")
    assert "'0' is not more than 0" in run("record", "nobody", "-o", path, option, "0", status=2)


def test_an_unknown_program_is_named_and_leaves_no_file(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    run("record", "nobody", "-o", str(path), status=1)
    assert not path.exists()


def test_topics_that_the_program_has_not_are_named(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    pid = str(pid_of(robots.start(APP)))
    words = ("record", pid, "-o", str(path), "--duration", "0.1s")
    error = run(*words, "/nope", status=2)
    assert "no topic /nope; there are: " in error
    assert "/position" in error
    assert not path.exists()
    assert "no topic /nope; there" in run_both(*words, "position", "nope")[1]
    assert path.exists()


def test_the_parameters_that_a_program_has_are_recorded(robots: Robots, tmp_path: Path) -> None:
    path = tmp_path / "app.mcap"
    robots.start(APP)
    run("record", "app", "-o", str(path), "--duration", "0.5s")
    with path.open("rb") as stream:
        found = [
            deserialize(entry.message.data, ParameterEvent)
            for entry in messages(stream)
            if entry.channel.topic == "/parameter_events"
        ]
    values = {one.name: one.value for event in found for one in event.new_parameters}
    assert values["robot.speed"].double_value == 1.5
    assert values["robot.names"].string_array_value == ("a", "b")


def test_a_program_that_keeps_its_recording_in_memory_writes_it_when_it_is_asked(
    robots: Robots, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    options = RecordOptions(path, last_s=60.0)
    robots.start(APP, env={RECORD_VARIABLE: options.to_text()})
    assert run("record", "app", "--save") == f"{path}\n"
    assert run("record", "app", "--save") == f"{tmp_path / 'run_1.mcap'}\n"
    with path.open("rb") as stream:
        assert is_complete(stream)
        assert {entry.channel.topic for entry in messages(stream)} >= {"/position", "/rosout"}


def test_a_program_that_keeps_nothing_says_so(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP)
    text = run("record", "app", "--save", status=1)
    assert text == "rosbase: this program does not record itself\n"
    robots.start(APP.replace('"app"', '"other"'), env={RECORD_VARIABLE: str(tmp_path / "run.mcap")})
    assert "keeps nothing in memory" in run("record", "other", "--save", status=1)
