"""The settings of a line, DTR and RTS, low latency, and the errors that a driver counts (S16).

Three stand-ins, because a pseudo-terminal answers none of the requests for modem lines, latency
and counts: `/dev/ttyS0`, where there is one that works (it is the console of many a virtual
machine; nothing is written to it, and it is left as it was), a fake driver at the ioctl, and for
DTR and RTS pyserial's server of RFC 2217 (`test_rfc2217.py`).
"""

import fcntl
import os
import struct
import tempfile
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from imu_serial.config import SerialConfig
from imu_serial.line import ask_for_low_latency, error_counts, set_lines, set_up
from imu_serial.port import Port
from rosbase.errors import NotADeviceError
from support.fake_driver import FakeDriver
from support.fast_clock import FastClock
from support.serial_rig import SerialRig
from support.waiting import wait_until

UART = "/dev/ttyS0"
DTR, RTS = termios.TIOCM_DTR, termios.TIOCM_RTS
ON, OFF = termios.TIOCMBIS, termios.TIOCMBIC
_ASYNC_LOW_LATENCY = 0x2000


def open_line(path: str) -> int:
    return os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)


def modem_lines(fd: int) -> int:
    (lines,) = struct.unpack("I", fcntl.ioctl(fd, termios.TIOCMGET, bytes(4)))
    return int(lines)


def is_uart() -> bool:
    try:
        fd = open_line(UART)
    except OSError:
        return False
    try:
        modem_lines(fd)
    except OSError:
        return False
    finally:
        os.close(fd)
    return True


needs_uart = pytest.mark.skipif(not is_uart(), reason=f"{UART} is no UART that works")


@pytest.fixture
def uart() -> Iterator[int]:
    """The UART of this machine, for one test at a time, and as it was before at the end."""
    with open(Path(tempfile.gettempdir()) / "rosbase-uart.lock", "w") as one_at_a_time:
        fcntl.flock(one_at_a_time, fcntl.LOCK_EX)
        fd = open_line(UART)
        settings = termios.tcgetattr(fd)
        driver = fcntl.ioctl(fd, termios.TIOCGSERIAL, bytes(128))
        lines = modem_lines(fd)
        yield fd
        termios.tcsetattr(fd, termios.TCSANOW, settings)
        fcntl.ioctl(fd, termios.TIOCSSERIAL, driver)
        for line in (DTR, RTS):
            fcntl.ioctl(fd, ON if lines & line else OFF, struct.pack("I", line))
        os.close(fd)


@pytest.fixture
def driver(monkeypatch: pytest.MonkeyPatch) -> FakeDriver:
    return FakeDriver(monkeypatch)


@pytest.fixture
def pty() -> Iterator[int]:
    near_end, far_end = os.openpty()
    yield far_end
    os.close(near_end)
    os.close(far_end)


# Which lines are on afterwards, and the requests that lead there: the kernel raises both.
WISHES = [
    ("leave", "leave", DTR | RTS, []),
    ("on", "leave", DTR | RTS, [(ON, DTR)]),
    ("leave", "on", DTR | RTS, [(ON, RTS)]),
    ("on", "on", DTR | RTS, [(ON, DTR | RTS)]),
    ("off", "leave", RTS, [(OFF, DTR)]),
    ("leave", "off", DTR, [(OFF, RTS)]),
    ("on", "off", DTR, [(ON, DTR), (OFF, RTS)]),
    ("off", "on", RTS, [(ON, RTS), (OFF, DTR)]),
    ("off", "off", 0, [(OFF, DTR | RTS)]),
]


@pytest.mark.parametrize(("dtr", "rts", "lines", "requests"), WISHES)
def test_dtr_and_rts_are_as_the_parameters_say(
    rig: SerialRig,
    driver: FakeDriver,
    dtr: str,
    rts: str,
    lines: int,
    requests: list[tuple[int, int]],
) -> None:
    """Where both go off, in one request: an ESP32 is reset while only one of them is on."""
    rig.port.plug()
    transport = rig.transport(dtr=dtr, rts=rts)
    for times in (1, 2):
        transport.open()
        assert (driver.modem, driver.requests) == (lines, requests * times)
        transport.start(rig.keep)
        transport.close()
    assert driver.requests == requests * 2, "closing changes nothing"


@needs_uart
@pytest.mark.parametrize(("dtr", "rts", "lines", "requests"), WISHES)
def test_the_lines_of_a_uart_are_as_the_parameters_say(
    uart: int, dtr: str, rts: str, lines: int, requests: object
) -> None:
    port = Port(SerialConfig(UART, 115_200, dtr=dtr, rts=rts))
    assert modem_lines(uart) & (DTR | RTS) == lines
    port.close()


@pytest.mark.parametrize("dtr", ["leave", "on", "off"])
def test_closing_does_not_lower_dtr_so_that_opening_does_not_raise_it(
    rig: SerialRig, dtr: str
) -> None:
    rig.port.plug()
    fd = open_line(rig.port.real_path)
    before = termios.tcgetattr(fd)
    before[2] |= termios.HUPCL
    termios.tcsetattr(fd, termios.TCSANOW, before)
    transport = rig.transport(dtr=dtr)
    transport.open()
    assert not termios.tcgetattr(fd)[2] & termios.HUPCL
    transport.close()
    assert not termios.tcgetattr(fd)[2] & termios.HUPCL
    os.close(fd)


@pytest.mark.parametrize(("dtr", "rts"), [("off", "leave"), ("leave", "on"), ("off", "off")])
def test_a_line_that_is_set_and_not_there_is_named_once(
    rig: SerialRig, caplog: pytest.LogCaptureFixture, dtr: str, rts: str
) -> None:
    rig.port.plug()
    transport = rig.transport(clock=FastClock(), dtr=dtr, rts=rts)
    transport.start(rig.keep)
    names = " and ".join(n for n, wish in (("dtr", dtr), ("rts", rts)) if wish != "leave")
    said = f"{rig.port.path} has no modem lines to set for {names}"
    wait_until(lambda: said in caplog.messages, "the remark")
    deadline = FastClock.monotonic_ns() + 10 * 10**9
    wait_until(lambda: FastClock.monotonic_ns() > deadline, "more looks")
    assert rig.said(caplog.messages) == [said]
    transport.close()
    port = Port(SerialConfig(rig.port.real_path, 115_200, dtr=dtr, rts=rts))
    remarks = [port.report(is_quiet=False).remark for _ in range(2)]
    assert [bool(remark) for remark in remarks] == [True, False]
    port.close()


def test_a_line_is_raw_and_one_byte_is_enough_whatever_it_was_before(pty: int) -> None:
    settings = termios.tcgetattr(pty)
    settings[0] = termios.ICRNL | termios.IXON | termios.ISTRIP | termios.INPCK
    settings[1] = termios.OPOST
    settings[2] |= termios.PARENB | termios.CSTOPB | termios.CRTSCTS | termios.HUPCL
    settings[3] = termios.ICANON | termios.ECHO | termios.ISIG
    termios.tcsetattr(pty, termios.TCSANOW, settings)
    set_up(pty, 57_600)
    iflag, oflag, cflag, lflag, ispeed, ospeed, cc = termios.tcgetattr(pty)
    assert (iflag, oflag, lflag) == (0, 0, 0)
    assert cflag & ~termios.CBAUD & 0xFFFF == termios.CS8 | termios.CREAD | termios.CLOCAL
    assert ispeed == ospeed == termios.B57600
    assert (cc[termios.VMIN], cc[termios.VTIME]) in ((1, 0), (b"\x01", b"\x00"))


def rate_of(fd: int) -> int:
    settings = struct.unpack("9I2I", fcntl.ioctl(fd, 0x802C542A, bytes(44)))
    return int(settings[-1])


@pytest.mark.parametrize("baudrate", [1, 74_880, 115_200, 250_000, 3_000_000, 20_000_000])
def test_every_rate_is_set_the_unusual_too(pty: int, baudrate: int) -> None:
    """74,880 is the rate of an ESP8266's boot text; 250,000 a favourite of Arduino firmware."""
    set_up(pty, baudrate)
    assert rate_of(pty) == baudrate


@needs_uart
@pytest.mark.parametrize(
    ("baudrate", "is_there"), [(9_600, True), (31_250, True), (921_600, False)]
)
def test_a_rate_that_a_uart_does_not_have_is_refused(
    uart: int, baudrate: int, is_there: bool
) -> None:
    """Before, it stayed at the rate before, and what came was noise."""
    (base_rate,) = struct.unpack_from("i", fcntl.ioctl(uart, termios.TIOCGSERIAL, bytes(128)), 28)
    assert base_rate < 921_600, "another UART than expected"
    config = SerialConfig(UART, baudrate)
    if is_there:
        Port(config).close()
        assert rate_of(uart) == pytest.approx(baudrate, rel=0.03)
    else:
        with pytest.raises(NotADeviceError, match=f"does not take {baudrate} baud: it runs at"):
            Port(config)


def test_low_latency_is_asked_for_where_the_driver_offers_it(
    rig: SerialRig, driver: FakeDriver
) -> None:
    rig.port.plug()
    Port(SerialConfig(rig.port.real_path, 115_200)).close()
    assert driver.flags == 0x10000000 | _ASYNC_LOW_LATENCY


@pytest.mark.parametrize("refused", [termios.TIOCGSERIAL, termios.TIOCSSERIAL])
def test_a_driver_that_offers_no_low_latency_is_read_as_it_is(
    rig: SerialRig, driver: FakeDriver, refused: int
) -> None:
    driver.refuses.add(refused)
    rig.started()


@needs_uart
def test_a_uart_takes_the_wish_for_low_latency(uart: int) -> None:
    assert ask_for_low_latency(uart)
    assert ask_for_low_latency(uart), "also a second time"
    flags = struct.unpack("32i", fcntl.ioctl(uart, termios.TIOCGSERIAL, bytes(128)))[4]
    assert flags & _ASYNC_LOW_LATENCY


def test_a_pseudo_terminal_offers_nothing_and_that_is_no_error(pty: int) -> None:
    assert not ask_for_low_latency(pty)
    assert error_counts(pty) is None
    assert set_lines(pty, "leave", "leave")
    assert not set_lines(pty, "off", "leave")


@needs_uart
def test_a_uart_tells_its_counts(uart: int) -> None:
    counts = error_counts(uart)
    assert counts is not None
    assert set(counts) == {
        "framing_error",
        "overrun",
        "parity_error",
        "line_break",
        "buffer_overrun",
    }


@pytest.mark.parametrize(
    ("seen", "reasons", "said"),
    [
        (
            {"frame": 214},
            {"framing_error": 214},
            "214 characters damaged (framing errors), as if sent at another rate than 115200 baud",
        ),
        (
            {"overrun": 3, "buf_overrun": 40},
            {"overrun": 3, "buffer_overrun": 40},
            "3 characters lost before the machine had read them (overrun); {}: "
            "40 characters lost because nobody read them in time (buffer overrun)",
        ),
        ({"parity": 1}, {"parity_error": 1}, "1 character damaged (parity errors)"),
        ({"brk": 2}, {"line_break": 2}, ""),
    ],
)
def test_s16_errors_that_the_driver_counts_are_counted_and_said(
    rig: SerialRig,
    driver: FakeDriver,
    caplog: pytest.LogCaptureFixture,
    seen: dict[str, int],
    reasons: dict[str, int],
    said: str,
) -> None:
    # What was before is not this reader's.
    driver.count(frame=1_000, overrun=1_000)
    rig.port.plug()
    transport = rig.transport(clock=FastClock())
    transport.start(rig.keep)
    rig.prove()
    assert transport.health.link_errors == {}
    driver.count(**seen)
    wait_until(lambda: transport.health.link_errors, "the errors to be counted")
    deadline = FastClock.monotonic_ns() + 5 * 10**9
    wait_until(lambda: FastClock.monotonic_ns() > deadline, "more looks")
    assert transport.health.link_errors == reasons
    expected = [f"{rig.port.path}: {said.format(rig.port.path)}"] if said else []
    assert rig.said(caplog.messages) == expected
    assert transport.health.last_error == "", "it goes on"


def test_s16_a_driver_that_begins_to_count_again_is_believed(
    rig: SerialRig, driver: FakeDriver
) -> None:
    rig.port.plug()
    driver.count(overrun=50)
    port = Port(SerialConfig(rig.port.real_path, 115_200))
    driver.count(overrun=2)
    assert port.report(is_quiet=False).errors == {"overrun": 2}
    driver.counts = [0] * 20
    driver.count(overrun=5)
    assert port.report(is_quiet=False).errors == {"overrun": 5}
    assert port.report(is_quiet=False).errors == {}
    port.close()


def test_s16_a_driver_that_does_not_count_is_not_asked_again(
    rig: SerialRig, driver: FakeDriver
) -> None:
    rig.port.plug()
    driver.refuses.add(0x545D)
    port = Port(SerialConfig(rig.port.real_path, 115_200))
    driver.refuses.clear()
    driver.count(overrun=2)
    assert port.report(is_quiet=False).errors == {}
    port.close()
