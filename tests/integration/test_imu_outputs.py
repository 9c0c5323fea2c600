"""`rosbase imu` with outputs that are slow, stopped, full, closed or gone."""

import os
import subprocess
import termios
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest

from rosbase.errors import TransportError
from support.command import ROSBASE, summary_of
from support.samples import GOOD_FRAME
from support.serial_port import PluggablePort


@contextmanager
def fed(port: PluggablePort) -> Iterator[None]:
    """Within it, samples and junk are sent as fast as they are read; it ends with the port."""

    def feed() -> None:
        with suppress(TransportError):
            while True:
                port.write((GOOD_FRAME + b"\n") * 20 + b"junk\n")

    feeder = threading.Thread(target=feed)
    feeder.start()
    try:
        yield
    finally:
        # Ends the feeder too, which may wait for room on the line.
        port.unplug()
        feeder.join()


def test_it_ends_quietly_when_nobody_reads_its_output(port: PluggablePort) -> None:
    port.plug()
    with subprocess.Popen(
        [ROSBASE, "imu", "-p", f"device_path:={port.path}", "--topic-echo"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as reader:
        assert reader.stdout is not None
        assert reader.stderr is not None
        reader.stdout.close()
        with fed(port):
            shown = reader.stderr.read()
    assert reader.returncode == 0
    assert "Traceback" not in shown
    assert "Exception" not in shown


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
        assert counts["published"] > 500
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
        with fed(port):
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
        try:
            with fed(port):
                assert reader.wait(15) == 0
        finally:
            reader.kill()
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
        with fed(port):
            shown = [reader.stdout.readline() for _ in range(500)]
            reader.terminate()
            reader.stdout.read()
    assert all("linear_acceleration" in line for line in shown)
    assert reader.returncode == 0


def test_a_user_error_that_nobody_hears_is_still_status_2() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [ROSBASE, "imu", "-p", "baudrate:=fast"], stderr=full, timeout=30, check=False
        )
    assert done.returncode == 2
