"""`rosbase imu` as a process, on a real line that another program writes to."""

import json
import os
import re
import signal
import subprocess
import termios
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from rosbase.errors import TransportError
from support.command import ROSBASE, RunningRosbase, run_rosbase, summary_of
from support.samples import FAULTS, GOOD_FRAME, frame
from support.serial_port import PluggablePort
from support.waiting import wait_until


@pytest.fixture
def port(tmp_path: Path) -> Iterator[PluggablePort]:
    port = PluggablePort(tmp_path)
    yield port
    port.unplug()


def echoing(port: PluggablePort, *more: str) -> RunningRosbase:
    """A reader on the port that prints what it publishes, once it does."""
    port.plug()
    reader = RunningRosbase("imu", "-p", f"device_path:={port.path}", "--topic-echo", *more)

    def is_reading() -> bool:
        port.write(GOOD_FRAME + b"\n")
        return bool(reader.out.lines)

    wait_until(is_reading, "the first sample")
    return reader


def says_more(reader: RunningRosbase, part: str, before: dict[str, int]) -> None:
    """Waits until it has said that more often than before."""
    wait_until(lambda: reader.err.count(part) > before[part], f"{part!r} to be said")


def next_sample(reader: RunningRosbase, port: PluggablePort, mark: float) -> None:
    """Sends a sample with a mark in it, and waits for that sample."""
    port.write(frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0}) + b"\r\n")
    reader.waits_for(f'"angular_velocity":{{"x":{mark},', where=reader.out)


def test_each_bad_line_is_dropped_and_counted_and_the_next_good_line_comes_through(
    port: PluggablePort,
) -> None:
    expected: dict[str, int] = {}
    with echoing(port) as reader:
        for number, (line, reason) in enumerate(FAULTS.values(), start=1):
            expected[reason] = expected.get(reason, 0) + 1
            port.write(line + b"\n")
            next_sample(reader, port, number + 0.5)
        port.write(b"x" * 70_000 + b"\n")
        next_sample(reader, port, 1000.5)
        assert reader.end(signal.SIGINT) == 0
    counts = summary_of(reader.err.lines)
    assert {reason: counts[reason] for reason in expected} == expected
    assert counts["overlong"] == 1
    assert counts["published"] == len(reader.out.lines)
    assert counts["received"] == counts["published"] + counts["rejected"] + counts["ignored"]
    assert "Traceback" not in reader.err


def test_each_published_sample_is_one_line_of_json_in_the_default_shape(
    port: PluggablePort,
) -> None:
    with echoing(port) as reader:
        next_sample(reader, port, 0.25)
        reader.end(signal.SIGTERM)
    for line in reader.out.lines:
        sample = json.loads(line)
        assert list(sample) == [
            "header",
            "orientation",
            "orientation_covariance",
            "angular_velocity",
            "angular_velocity_covariance",
            "linear_acceleration",
            "linear_acceleration_covariance",
        ]
        assert sample["linear_acceleration"]["z"] == 9.80665
        assert sample["header"]["frame_id"] == "imu_link"


def test_what_it_prints_can_be_read_by_another_reader(port: PluggablePort, tmp_path: Path) -> None:
    with echoing(port) as first:
        next_sample(first, port, 0.25)
        first.end(signal.SIGTERM)
    (tmp_path / "second").mkdir()
    second_port = PluggablePort(tmp_path / "second")
    with echoing(second_port, "-p", "time_source:=device") as second:
        second_port.write(first.out.lines[-1].encode() + b"\n")
        wait_until(lambda: second.out.lines[-1] == first.out.lines[-1], "the same sample")
        second.end(signal.SIGTERM)
    second_port.unplug()


def test_unplugging_and_replugging_needs_no_action(port: PluggablePort) -> None:
    with echoing(port) as reader:
        for number in range(1, 4):
            before = {part: reader.err.count(part) for part in ("trying again", "is back")}
            port.unplug()
            says_more(reader, "trying again", before)
            port.plug()
            says_more(reader, "is back", before)

            def is_reading(mark: float = number + 0.125) -> bool:
                port.write(frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0}) + b"\n")
                return f'"x":{mark},' in reader.out

            wait_until(is_reading, "samples after the replug")
        assert reader.end(signal.SIGINT) == 0
    assert summary_of(reader.err.lines)["reconnects"] == 3


def test_an_absent_device_is_said_in_one_line_and_the_node_stays_unconfigured() -> None:
    done = run_rosbase("imu", "-p", "device_path:=/dev/does-not-exist", "--duration", "1.5")
    assert done.returncode == 0
    (line,) = done.stderr.splitlines()
    assert "/dev/does-not-exist is not there" in line
    assert "unconfigured" in done.stdout.splitlines()[0]
    assert summary_of(done.stdout.splitlines())["published"] == 0


def test_an_absent_device_is_waited_for_by_option(port: PluggablePort) -> None:
    with RunningRosbase(
        "imu", "-p", f"device_path:={port.path}", "-p", "wait_for_device:=true", "--topic-echo"
    ) as reader:
        reader.waits_for("is not there")
        port.plug()
        reader.waits_for("is there")

        def is_reading() -> bool:
            port.write(GOOD_FRAME + b"\n")
            return bool(reader.out.lines)

        wait_until(is_reading, "the first sample")
        assert reader.end(signal.SIGINT) == 0
    assert "Traceback" not in reader.err


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["-p", "baudrate:=fast"], "parameter baudrate takes a whole number, not 'fast'"),
        (["-p", "baudrate:=0"], "parameter baudrate is at least 1, not 0"),
        (["-p", "device:=x"], "unknown parameter 'device'; did you mean device_path?"),
        (["-p", "comm_t:=mqtt"], "needs the package imu-mqtt: pip install imu-mqtt"),
        (["-p", "comm_t:=seriel"], "no transport 'seriel'; installed: serial; did you mean"),
        (["--backend", "ros2"], "needs the package rosbase-ros2: pip install rosbase-ros2"),
    ],
)
def test_a_wrong_parameter_is_one_line_and_status_2(arguments: list[str], line: str) -> None:
    done = run_rosbase("imu", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert line in done.stderr


def test_plugins_answers_in_well_under_half_a_second() -> None:
    def took_s() -> float:
        start = time.monotonic()
        assert run_rosbase("plugins").returncode == 0
        return time.monotonic() - start

    assert min(took_s() for _ in range(5)) < 0.4


def test_autostart_goes_as_far_as_it_is_told(port: PluggablePort) -> None:
    port.plug()
    for autostart, state in (("none", "unconfigured"), ("configure", "inactive")):
        done = run_rosbase(
            "imu", "-p", f"device_path:={port.path}", "-p", f"autostart:={autostart}",
            "--duration", "1.5",
        )  # fmt: skip
        assert done.returncode == 0
        assert done.stdout.splitlines()[0] == state


def test_it_ends_quietly_when_nobody_reads_its_output(port: PluggablePort) -> None:
    port.plug()
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as reader:
        assert reader.stdout is not None
        reader.stdout.close()

        def has_ended() -> bool:
            port.write(GOOD_FRAME + b"\n")
            return reader.poll() is not None

        wait_until(has_ended, "the end")
        assert reader.stderr is not None
        shown = reader.stderr.read()
    assert reader.returncode == 0
    assert "Traceback" not in shown
    assert "Exception" not in shown


def our_code_runs(pid: int) -> bool:
    """Whether the command has begun: Python ignores SIGPIPE and catches SIGINT, ours does not."""
    status = Path(f"/proc/{pid}/status").read_text()
    masks = {
        name: int(mask, 16)
        for name, mask in re.findall(r"^(Sig\w+):\s(\w+)$", status, re.MULTILINE)
    }
    ignores_pipe = masks["SigIgn"] >> (signal.SIGPIPE - 1) & 1
    catches_int = masks["SigCgt"] >> (signal.SIGINT - 1) & 1
    return bool(ignores_pipe and not catches_int)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_at_any_early_moment_ends_it_without_a_traceback(
    port: PluggablePort, signum: int
) -> None:
    port.plug()
    for delay_ms in range(0, 300, 20):
        with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
            wait_until(partial(our_code_runs, reader.process.pid), "Python's own start")
            # Not to wait for something, but to come at another moment each time.
            time.sleep(delay_ms / 1000)
            status = reader.end(signum)
        assert status in (0, -signum)
        assert reader.err.count("Traceback") == 0, reader.err.lines
    with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")
        assert reader.end(signum) == 0
    assert "published 0" in reader.out


@pytest.mark.parametrize("ending", ["signal", "duration"])
def test_a_pipe_that_nobody_empties_does_not_hold_up_the_end(
    port: PluggablePort, ending: str
) -> None:
    port.plug()
    more = ["--duration", "3"] if ending == "duration" else []
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo", *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as reader:
        assert reader.stderr is not None
        assert "opened" in reader.stderr.readline()
        # Far more than a pipe holds.
        for _ in range(1000):
            port.write(GOOD_FRAME + b"\n")
        if ending == "signal":
            assert " Hz " in next(line for line in reader.stderr if " Hz " in line)
            reader.terminate()
        assert reader.wait(10) == 0
        counts = summary_of(reader.stderr.read().splitlines())
        assert counts["published"] > 900
        assert 0 < counts["dropped"] < counts["published"]


@pytest.mark.parametrize("command", ["imu", "demo"])
def test_it_ends_quietly_when_nobody_reads_its_report(port: PluggablePort, command: str) -> None:
    port.plug()
    device = ["-p", f"device_path:={port.path}"] if command == "imu" else []
    with subprocess.Popen(
        [ROSBASE, command, *device], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as reader:
        assert reader.stdout is not None
        assert reader.stderr is not None
        reader.stdout.readline()
        reader.stdout.close()
        assert reader.wait(20) == 0
        assert "Traceback" not in reader.stderr.read()


def test_it_ends_when_nobody_reads_the_samples_of_a_silent_device(port: PluggablePort) -> None:
    port.plug()
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as reader:
        assert reader.stdout is not None
        assert reader.stderr is not None
        assert "opened" in reader.stderr.readline()
        reader.stdout.close()
        assert reader.wait(10) == 0
        assert "Traceback" not in reader.stderr.read()


def test_a_magnetic_field_is_echoed_too(port: PluggablePort) -> None:
    port.plug()
    with RunningRosbase(
        "imu", "-p", f"device_path:={port.path}", "-p", "preset:=custom", "--topic-echo",
        "-p", "mapping.magnetic_field.paths:=m", "-p", "mapping.magnetic_field.unit:=uT",
    ) as reader:  # fmt: skip
        reader.waits_for("opened")

        def arrives() -> bool:
            port.write(b'{"m":[1,2,3]}\n')
            return '"magnetic_field":' in reader.out

        wait_until(arrives, "a magnetic field")
        assert reader.end(signal.SIGINT) == 0


def test_samples_on_a_full_disk_end_it_with_one_line(port: PluggablePort) -> None:
    port.plug()
    with (
        open("/dev/full", "w") as full,
        subprocess.Popen(
            [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        ) as reader,
    ):
        assert reader.stderr is not None

        def has_ended() -> bool:
            port.write(GOOD_FRAME + b"\n")
            return reader.poll() is not None

        wait_until(has_ended, "the end")
        shown = reader.stderr.read().splitlines()
    assert reader.returncode == 1
    assert shown[-1] == "rosbase: cannot write: No space left on device"


def stopped_terminal() -> tuple[int, int]:
    """A terminal whose output somebody has stopped with Ctrl-S: both of its ends."""
    own_end, far_end = os.openpty()
    termios.tcflow(far_end, termios.TCOOFF)
    return own_end, far_end


def full_pipe() -> tuple[int, int]:
    """A pipe that is full and that nobody empties: both of its ends."""
    own_end, far_end = os.pipe()
    os.set_blocking(far_end, False)
    try:
        while True:
            os.write(far_end, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(far_end, True)
    return own_end, far_end


def unread_terminal() -> tuple[int, int]:
    """A terminal whose other end nobody reads."""
    return os.openpty()


def feed(port: PluggablePort) -> None:
    """Sends samples and junk until the port is unplugged."""
    try:
        while True:
            port.write((GOOD_FRAME + b"\n") * 20 + b"junk\n")
    except (TransportError, AssertionError):
        return


@pytest.mark.parametrize("make", [stopped_terminal, full_pipe, unread_terminal])
@pytest.mark.parametrize("streams", [["stdout"], ["stderr"], ["stdout", "stderr"]])
def test_streams_that_take_nothing_do_not_hold_up_the_end(
    port: PluggablePort, make: Callable[[], tuple[int, int]], streams: list[str]
) -> None:
    port.plug()
    own_end, far_end = make()
    ends = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo", "--duration", "1.5"],
        stdout=far_end if "stdout" in streams else ends["stdout"],
        stderr=far_end if "stderr" in streams else ends["stderr"],
    ) as reader:
        feeder = threading.Thread(target=feed, args=(port,))
        feeder.start()
        try:
            assert reader.wait(15) == 0
        finally:
            reader.kill()
            # Ends the feeder too, which may wait for room on the line.
            port.unplug()
            feeder.join()
    os.close(own_end)
    os.close(far_end)


def test_a_log_that_nobody_reads_does_not_end_the_samples(port: PluggablePort) -> None:
    port.plug()
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as reader:
        assert reader.stdout is not None
        assert reader.stderr is not None
        assert "opened" in reader.stderr.readline()
        reader.stderr.close()
        feeder = threading.Thread(target=feed, args=(port,))
        feeder.start()
        shown = [reader.stdout.readline() for _ in range(500)]
        reader.terminate()
        reader.stdout.read()
        port.unplug()
        feeder.join()
    assert all("linear_acceleration" in line for line in shown)
    assert reader.returncode == 0


def test_a_user_error_that_nobody_hears_is_still_status_2() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [ROSBASE, "imu", "-p", "baudrate:=fast"], stderr=full, timeout=30, check=False
        )
    assert done.returncode == 2
