"""A device that sends anything at all costs the reader bounded memory and a few lines of log."""

import itertools
import json
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from rosbase.errors import TransportError
from support.command import RunningRosbase
from support.memory import worst_growth_kb
from support.samples import FAULTS, GOOD_FRAME
from support.serial_port import PluggablePort
from support.waiting import wait_until

MOST_GROWTH_KB = 20_000
END_S = 3.0


def every_fault() -> Iterator[bytes]:
    lines = [line + b"\n" for line, _ in FAULTS.values()]
    return itertools.cycle(lines)


def ever_new_keys() -> Iterator[bytes]:
    for n in itertools.count():
        words = {f"{n}-{k} \x1b[2J\u202e": [k] * 20 for k in range(50)}
        yield json.dumps(words, ensure_ascii=False).encode() + b"\n"


def ever_new_boot_texts() -> Iterator[bytes]:
    for n in itertools.count():
        yield b"[%d] boot \x1b]0;title\x07\n" % n


def no_line_end() -> Iterator[bytes]:
    return itertools.repeat(b"A" * 5_000)


def noise() -> Iterator[bytes]:
    return itertools.repeat(bytes(range(128, 256)) * 40)


def lines_of_the_longest_kind() -> Iterator[bytes]:
    return itertools.repeat(b'{"a":[' + b"1," * 32_000 + b"1]}\n")


def good_samples() -> Iterator[bytes]:
    return itertools.repeat((GOOD_FRAME + b"\n") * 20)


SENDERS = [
    every_fault,
    ever_new_keys,
    ever_new_boot_texts,
    no_line_end,
    noise,
    lines_of_the_longest_kind,
    good_samples,
]


@pytest.mark.parametrize("sender", SENDERS, ids=lambda sender: sender.__name__)
def test_the_reader_does_not_grow_says_little_and_ends(
    port: PluggablePort, sender: Callable[[], Iterator[bytes]]
) -> None:
    def feed() -> None:
        with suppress(TransportError):
            for part in sender():
                port.write(part)

    port.plug()
    feeder = threading.Thread(target=feed)
    with RunningRosbase("imu", "-p", f"device_path:={port.path}", "--topic-echo") as reader:

        def is_reading() -> bool:
            port.write(GOOD_FRAME + b"\n")
            return bool(reader.out.lines)

        wait_until(is_reading, "the first sample")
        feeder.start()
        try:
            assert worst_growth_kb(reader.process.pid, 2.0) < MOST_GROWTH_KB
            begun_s = time.monotonic()
            assert reader.end(signal.SIGINT) == 0
            assert time.monotonic() - begun_s < END_S
        finally:
            port.unplug()
            feeder.join()
    log = [line for line in reader.err.lines if line.startswith("[")]
    assert len(log) < 30, log
    assert all(line.isprintable() and len(line) < 700 for line in log)
