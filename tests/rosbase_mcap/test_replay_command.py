"""`rosbase replay`: what it runs, and what it refuses."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from rosbase.cli import main
from rosbase.entries.sink import RunFacts
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.records import Channel, Kind, Metadata, Schema
from rosbase_mcap.replaying.options import ReplayOptions
from rosbase_mcap.scanning import records_of
from rosbase_mcap.traces import Run, run_metadata

S = 1_000_000_000
START = 1_700_000_000 * S
MORE = {
    "argv": ["robot.py", "--fast"],
    "environment": {"ROSBASE_LOG_LEVEL": "debug", "ROSBASE_CONTROL": "off"},
    "hash_seed": "17",
}
RUN = Run("abc", 0, "start", frozenset(), RunFacts(START, 5, MORE))
Made = tuple[list[str], dict[str, str]]


class _ReplacedError(Exception):
    """This process would be another one now."""


@pytest.fixture
def replaced(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Made]:
    """Runs the command; returns the arguments and the environment of the new process."""

    def run(*words: object) -> Made:
        found: list[Made] = []

        def replace(path: str, arguments: list[str], environment: dict[str, str]) -> None:
            assert path == sys.executable
            found.append((arguments[1:], environment))
            raise _ReplacedError

        with monkeypatch.context() as patch:
            patch.setattr(os, "execve", replace)
            with pytest.raises(_ReplacedError):
                main(["replay", *map(str, words)])
        return found[0]

    return run


def recording(path: Path, *metadata: Metadata) -> Path:
    pieces = list[bytes | memoryview]()
    writer = FileWriter(pieces.append)
    for one in metadata:
        writer.note(one)
    writer.declare(Channel(0, 1, "/a", "cdr"), Schema(1, "std_msgs/msg/String", "ros2msg", b""))
    writer.add(0, 0, START, START, b"")
    writer.finish()
    path.write_bytes(b"".join(pieces))
    return path


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    return recording(tmp_path / "run.mcap", run_metadata(RUN))


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    return recording(tmp_path / "bag.mcap")


def options_in(made: Made) -> ReplayOptions:
    assert made[0][:2] == ["-m", "rosbase_mcap.replaying"]
    return ReplayOptions.from_text(made[0][2])


def test_the_program_has_the_surroundings_of_the_recording(
    whole: Path, replaced: Callable[..., Made], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_PARAMETERS", "[]")
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    monkeypatch.setenv("HOME", "/home/here")
    arguments, environment = replaced(whole)
    assert arguments[3:] == ["robot.py", "--fast"]
    assert environment["ROSBASE_LOG_LEVEL"] == "debug"
    assert environment["PYTHONHASHSEED"] == "17"
    assert environment["HOME"] == "/home/here"
    # Of the variables of the machine and of the file, only these are for a program.
    assert {name for name in environment if name.startswith("ROSBASE_")} == {"ROSBASE_LOG_LEVEL"}


def test_another_program_has_the_arguments_of_the_recording(
    whole: Path, replaced: Callable[..., Made]
) -> None:
    assert replaced(whole, "other.py")[0][3:] == ["other.py", "--fast"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], {}),
        (["--frames"], {}),
        (["--rate", "2.5"], {"rate": 2.5}),
        (["--as-fast"], {"rate": None}),
        (["--check"], {"rate": None, "checks": True}),
        (["--check", "--rate", "2x"], {"rate": 2.0, "checks": True}),
        (["--topics"], {"topics": []}),
        (["--topics", "/a", "b"], {"topics": ["/a", "/b"]}),
        (["--from", "1.5s", "--to", "2min"], {"start_ns": 1_500_000_000, "end_ns": 120 * S}),
        (["--from", "2023-11-14T22:13:21Z"], {"start_ns": S}),
    ],
)
def test_options_reach_the_replay(
    words: list[str], expected: dict[str, Any], whole: Path, replaced: Callable[..., Made]
) -> None:
    made = replaced(whole, "robot.py", *words)
    assert options_in(made) == evolve(ReplayOptions(whole), **expected)


def test_a_file_of_messages_alone_is_replayed_by_topics(
    bag: Path, replaced: Callable[..., Made], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_CONTROL", "off")
    made = replaced(bag, "robot.py", "--to", "1s", "--", "--slow", "-p", "gain:=2")
    assert options_in(made) == ReplayOptions(bag, (), end_ns=S)
    # As with `rosbase run`.
    assert made[0][3:] == ["robot.py", "--slow"]
    assert "gain" in made[1]["ROSBASE_PARAMETERS"]
    assert made[1]["ROSBASE_CONTROL"] == "off"


def refused(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    try:
        status = main(["replay", *map(str, words)])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    return line


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--frames", "--topics", "/a"], "not allowed with"),
        (["--rate", "2", "--as-fast"], "not allowed with"),
        (["--rate", "0"], "not a positive number"),
        (["--rate", "nan"], "not a positive number"),
        (["--check", "--topics", "/a"], "leave out --topics"),
        (["--from", "soon"], "not a time span"),
        (["--from=-1s"], "not a time span"),
        (["--from", "5s", "--to", "1s"], "--from 5s is after --to 1s"),
        (["--to", "2020-01-01"], "before the start"),
        (["--", "--slow"], "the arguments of the recording"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(
    words: list[str], reason: str, whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert reason in refused(capsys, whole, "robot.py", *words)


@pytest.mark.parametrize(
    ("begins", "reason"), [("ring", "the last seconds"), ("attach", "while the program ran")]
)
def test_a_recording_without_a_beginning_has_topics_only(
    begins: str,
    reason: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    replaced: Callable[..., Made],
) -> None:
    path = recording(tmp_path / "run.mcap", run_metadata(evolve(RUN, begins=begins)))
    line = refused(capsys, path, "robot.py")
    assert reason in line
    assert "use --topics" in line
    assert options_in(replaced(path, "robot.py", "--topics")).topics == ()


def test_all_inputs_of_a_file_without_any_are_refused(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "has messages only" in refused(capsys, bag, "robot.py", "--frames")
    assert "has messages only" in refused(capsys, bag, "robot.py", "--check", "--frames")
    assert "nothing can be compared" in refused(capsys, bag, "robot.py", "--check")


def test_a_file_that_names_no_program_needs_one(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "give it after the file" in refused(capsys, bag)


def test_a_recording_with_missing_messages_is_not_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], replaced: Callable[..., Made]
) -> None:
    lost = Metadata("rosbase_dropped", {"messages": "3"})
    path = recording(tmp_path / "run.mcap", run_metadata(RUN), lost)
    assert "3 messages are missing" in refused(capsys, path, "--check")
    assert replaced(path)


def test_a_damaged_recording_is_not_compared(
    whole: Path, capsys: pytest.CaptureFixture[str], replaced: Callable[..., Made]
) -> None:
    with whole.open("rb") as stream:
        [chunk] = [found for found in records_of(stream) if found.kind == Kind.CHUNK]
    data = bytearray(whole.read_bytes())
    data[chunk.end - 1] ^= 1
    whole.write_bytes(data)
    assert f"{whole} cannot be compared: 1 damaged chunk" in refused(capsys, whole, "--check")
    assert replaced(whole)


def test_a_file_that_is_none_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.mcap"
    assert "No such file" in refused(capsys, path, "robot.py")
    path.write_bytes(b"this is none")
    assert f"{path}: this is no MCAP file" in refused(capsys, path, "robot.py")
