"""The checks of samples. Each can warn, reject, or be off, as its parameter says."""

from typing import ClassVar, Protocol

from attrs import frozen

from rosbase.imu.checks.checksum import NO_CHECKSUM
from rosbase.imu.checks.direction import GravityDirection
from rosbase.imu.checks.frozen import Frozen
from rosbase.imu.checks.gravity import Gravity
from rosbase.imu.checks.window import WINDOW, Window, summarise
from rosbase.imu.mapping import VECTORS, ImuMapping, Sample
from rosbase.imu.units import UNITS
from rosbase.mapping.rejects import Reject

__all__ = ["CHECK_MODES", "CheckSettings", "Checks"]

CHECK_MODES = ("warn", "reject", "off")
"""Modes of a check: how it treats samples with a fault."""


class _Check(Protocol):
    """A check with its reason for refused samples, and a finding that comes and goes."""

    reason: ClassVar[str]
    finding: str


class _WindowCheck(_Check, Protocol):
    def judge(self, window: Window) -> None: ...


@frozen
class CheckSettings:
    """Settings of the checks, and how strict they are."""

    gravity: str = "warn"
    gravity_direction: str = "warn"
    frozen: str = "warn"
    frozen_after_s: float = 2.0
    device_clock: str = "warn"
    """Mode of the check of the device's date: `warn`, `arrival` or `off`."""
    device_clock_limit_s: float = 5.0
    checksum: str = NO_CHECKSUM
    """One of CHECKSUMS, or NO_CHECKSUM."""
    checksum_separator: str = "*"


class Checks:
    """Watches samples, and keeps each finding until its fault is gone."""

    def __init__(self, settings: CheckSettings, mapping: ImuMapping) -> None:
        """Prepare the checks that are not off.

        Args:
            settings: Modes of the checks.
            mapping: Format of numbers and quaternions in the payload.
        """
        gravity = Gravity()
        direction = GravityDirection(mapping.orientation_order or "xyzw")
        frozen = Frozen(settings.frozen_after_s, _factors(mapping))
        modes: dict[_Check, str] = {
            gravity: settings.gravity,
            direction: settings.gravity_direction,
            frozen: settings.frozen,
        }
        self._all = [check for check, mode in modes.items() if mode != "off"]
        self._refusing = [check for check, mode in modes.items() if mode == "reject"]
        of_windows: list[_WindowCheck] = [gravity, direction]
        self._of_windows = [check for check in of_windows if check in self._all]
        self._window: list[Sample] = []
        self._window_began_ns: int | None = None
        self._frozen = frozen if frozen in self._all else None

    @property
    def finding(self) -> str:
        """Fault of the samples, in one line; empty if there is none."""
        return "; ".join([check.finding for check in self._all if check.finding])

    def judge(self, sample: Sample, arrived_ns: int) -> Reject | None:
        """Take a sample; return why it is dropped, if it is."""
        acceleration = sample[2]
        if acceleration is not None and self._of_windows:
            window = self._window
            window.append(sample)
            if len(window) >= WINDOW:
                self._judge_window(arrived_ns)
        frozen = self._frozen
        if frozen is not None:
            # Compared here, because a call for each sample costs more than what it would do.
            if acceleration is None or acceleration == frozen.acceleration or frozen.repeats:
                frozen.add(sample, arrived_ns)
            else:
                frozen.acceleration = acceleration
        return self._refuse() if self._refusing else None

    def _refuse(self) -> Reject | None:
        for check in self._refusing:
            if check.finding:
                return Reject(check.reason, check.finding)
        return None

    def _judge_window(self, ended_ns: int) -> None:
        began_ns = ended_ns if self._window_began_ns is None else self._window_began_ns
        window = summarise(self._window, began_ns, ended_ns)
        self._window, self._window_began_ns = [], ended_ns
        for check in self._of_windows:
            check.judge(window)


def _factors(mapping: ImuMapping) -> dict[str, float]:
    """Return the factors by which the numbers of a payload were multiplied, by quantity."""
    units = {quantity: getattr(mapping, f"{quantity}_unit") for quantity in VECTORS}
    return {quantity: UNITS[quantity].get(unit, 1.0) for quantity, unit in units.items()}
