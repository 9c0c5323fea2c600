"""What is written to a pipe that is slow, full or gone."""

import os
from collections.abc import Iterator

import pytest

from rosbase.cli.output import Output
from rosbase.clock import SystemClock
from rosbase.testing import ManualClock


class Pipe:
    """Both ends of a pipe, and an output on one of them."""

    def __init__(self) -> None:
        self.read_fd, write_fd = os.pipe()
        self.stream = os.fdopen(write_fd, "w")
        self.output = Output(self.stream)

    def read(self, size: int = 1 << 20) -> str:
        return os.read(self.read_fd, size).decode()


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    pipe = Pipe()
    yield pipe
    pipe.stream.close()
    try:
        os.close(pipe.read_fd)
    except OSError:
        # The test has closed it.
        pass


def test_what_fits_is_written_at_once(pipe: Pipe) -> None:
    pipe.output.write("one\n")
    pipe.output.write("two\n")
    assert pipe.read() == "one\ntwo\n"
    assert not pipe.output.is_terminal


def test_a_full_pipe_holds_nothing_up_and_loses_nothing_below_the_limit(pipe: Pipe) -> None:
    lines = [f"{number:099d}\n" for number in range(5000)]
    for line in lines:
        pipe.output.write(line)
    got = ""
    while len(got) < 5000 * 100:
        got += pipe.read()
        pipe.output.flush()
    assert got == "".join(lines)
    assert pipe.output.dropped == 0


def test_beyond_the_limit_whole_lines_are_dropped_and_counted(pipe: Pipe) -> None:
    lines = [f"{number:099d}\n" for number in range(12_000)]
    for line in lines:
        pipe.output.write(line)
    got = ""
    while not got.endswith(lines[-1]):
        got += pipe.read()
        pipe.output.flush()
    assert set(got.splitlines(keepends=True)) <= set(lines)
    assert got.count("\n") == 12_000 - pipe.output.dropped
    assert pipe.output.dropped > 0


def test_draining_ends_in_time_and_counts_what_nobody_took(pipe: Pipe) -> None:
    for _ in range(2000):
        pipe.output.write("x" * 99 + "\n")
    pipe.output.drain(0.05, SystemClock())
    assert 1000 < pipe.output.dropped < 2000


def test_a_reader_that_is_gone_is_noticed_without_writing(pipe: Pipe) -> None:
    os.close(pipe.read_fd)
    pipe.output.flush()
    assert pipe.output.is_gone
    pipe.output.write("x\n")
    pipe.output.drain(1.0, ManualClock())
    assert pipe.output.error == ""


def test_a_full_disk_is_told_by_its_reason() -> None:
    with open("/dev/full", "w") as full:
        output = Output(full)
        output.write("x\n")
        assert output.is_gone
        assert output.error == "No space left on device"
