"""Faults of a simulated IMU, as on real boards and lines, for people to try."""

import json
import re
from collections.abc import Callable, Iterable, Mapping

from attrs import frozen

from rosbase.imu.simulator import Fault

__all__ = ["FAULTS", "FaultKind"]

_OFTEN, _SELDOM = 10, 50


@frozen
class FaultKind:
    """A fault that users can choose by name."""

    summary: str
    """Description of the fault, and of the reader's reaction."""
    make: Callable[[], Fault]
    """Makes the fault, for one run."""


def _every(period: int, spoil: Callable[[bytes], Iterable[bytes]]) -> Callable[[], Fault]:
    """Spoil one sample in every `n`, and send the others unchanged."""

    def fault(number: int, payload: bytes) -> Iterable[bytes]:
        return spoil(payload) if number % period == period - 1 else (payload,)

    return lambda: fault


def _cut(payload: bytes) -> Iterable[bytes]:
    yield payload[: len(payload) // 2]


def _noise(payload: bytes) -> Iterable[bytes]:
    yield bytes(byte ^ 0xA5 for byte in payload[:40])
    yield payload


def _not_a_number(payload: bytes) -> Iterable[bytes]:
    yield re.sub(rb'("linear_acceleration":\{"x":)[^,]*', rb"\g<1>NaN", payload)


def _spike(payload: bytes) -> Iterable[bytes]:
    sample = json.loads(payload)
    sample["linear_acceleration"]["z"] = 4000.0
    yield json.dumps(sample).encode()


def _message(payload: bytes) -> Iterable[bytes]:
    yield b"I (1234) imu: calibration done, temp=21.5"
    yield payload


def _make_frozen() -> Fault:
    """Repeat the same numbers after two hundred samples, under new dates."""
    last = b""

    def fault(number: int, payload: bytes) -> Iterable[bytes]:
        nonlocal last
        header, separator, rest = payload.partition(b'"orientation":')
        if number < 200:
            last = rest
        yield header + separator + last

    return fault


FAULTS: Mapping[str, FaultKind] = {
    "cut": FaultKind(
        "one line in 10 is cut in half: it is dropped, and counted as bad_json",
        _every(_OFTEN, _cut),
    ),
    "frozen": FaultKind(
        "after 200 samples the sensor gives the same numbers for ever: health WARN", _make_frozen
    ),
    "message": FaultKind(
        "the firmware prints a message of its own between samples: counted as not_data",
        _every(_SELDOM, _message),
    ),
    "nan": FaultKind(
        "one sample in 10 has NaN for a number: it is dropped, and counted as non_finite",
        _every(_OFTEN, _not_a_number),
    ),
    "noise": FaultKind(
        "bytes of noise on the line, once in 50 samples: counted as not_utf8",
        _every(_SELDOM, _noise),
    ),
    "spike": FaultKind(
        "one sample in 50 is far beyond the full scale: counted as out_of_range",
        _every(_SELDOM, _spike),
    ),
}
"""Faults by name."""
