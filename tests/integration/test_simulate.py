"""`rosbase simulate`: a device to play with, read by the command that it prints."""

import re
import shlex
import signal

import pytest

from support.command import RunningRosbase, run_rosbase, summary_of


def command_in(lines: list[str]) -> list[str]:
    """The words after `rosbase` of the command that was printed."""
    (line,) = [line for line in lines if line.strip().startswith("rosbase imu")]
    return shlex.split(line)[1:]


@pytest.mark.parametrize(("transport", "more"), [("serial", []), ("mqtt", ["--transport", "mqtt"])])
@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_the_command_that_it_prints_reads_it(transport: str, more: list[str], signum: int) -> None:
    with RunningRosbase("simulate", "--rate", "50", *more) as board:
        board.waits_for("rosbase imu", where=board.out)
        done = run_rosbase(*command_in(board.out.lines), "--duration", "3")
        assert done.returncode == 0, done.stderr
        counts = summary_of(done.stdout.splitlines())
        assert 50 < counts["published"] < 200
        assert counts["rejected"] <= 1, "what was cut when the port was opened"
        assert board.end(signum) == 0
    assert re.fullmatch(r"sent \d+", board.out.lines[-1])
    assert board.err.lines == []


def test_its_plug_is_pulled_again_and_again() -> None:
    with RunningRosbase("simulate", "--fault", "unplug") as board:
        board.waits_for("rosbase imu", where=board.out)
        with RunningRosbase(*command_in(board.out.lines)) as reader:
            reader.waits_for("is back")
            assert reader.end(signal.SIGINT) == 0
        assert board.end(signal.SIGINT) == 0
    assert summary_of(reader.out.lines)["reconnects"] == 1


def test_a_fault_shows_in_the_counts_of_the_reader() -> None:
    with RunningRosbase("simulate", "--fault", "spike", "--duration", "20") as board:
        board.waits_for("rosbase imu", where=board.out)
        done = run_rosbase(*command_in(board.out.lines), "--duration", "2")
        assert board.end(signal.SIGINT) == 0
    assert summary_of(done.stdout.splitlines())["out_of_range"] >= 2


def test_it_ends_in_its_time() -> None:
    done = run_rosbase("simulate", "--duration", "0.5")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--fault", "fire"], "invalid choice: 'fire'"),
        (["--transport", "x"], "no transport 'x'"),
        (["--rate", "0"], "'0' is not a positive number"),
    ],
)
def test_a_wrong_argument_is_one_line_and_status_2(arguments: list[str], line: str) -> None:
    done = run_rosbase("simulate", *arguments)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert line in done.stderr
