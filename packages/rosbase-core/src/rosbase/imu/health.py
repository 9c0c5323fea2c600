"""How well the reader is: by what arrives, never by what a library believes."""

from enum import IntEnum

from attrs import frozen

from rosbase.contracts.transport import TransportHealth, TransportState
from rosbase.imu.counts import CountsSnapshot
from rosbase.imu.rejects import REASONS

__all__ = ["Health", "HealthLevel", "judge_health"]

_ERROR_AFTER = 5.0
_ENOUGH_FRAMES = 5


class HealthLevel(IntEnum):
    """The values are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@frozen
class Health:
    """A level, and why, in one line."""

    level: HealthLevel
    message: str


def judge_health(
    transport: TransportHealth,
    silence_s: float,
    stale_timeout_s: float,
    before: CountsSnapshot,
    now: CountsSnapshot,
    finding: str = "",
) -> Health:
    """The health of an active reader.

    Args:
        transport: How the transport is.
        silence_s: Seconds since data last arrived, or since activation.
        stale_timeout_s: Silence after which it is WARN; five times that is ERROR.
        before: The counts at an earlier moment.
        now: The counts now.
        finding: What the plausibility check found.
    """
    if transport.state is TransportState.RECONNECTING:
        return Health(HealthLevel.ERROR, f"waiting for the device: {transport.last_error}")
    if silence_s > stale_timeout_s:
        late = silence_s > _ERROR_AFTER * stale_timeout_s
        level = HealthLevel.ERROR if late else HealthLevel.WARN
        return Health(level, f"no data for {silence_s:.1f} s")
    if transport.last_error:
        # It is there at this moment, and has not proved to stay.
        return Health(HealthLevel.ERROR, transport.last_error)
    if now.received - before.received >= _ENOUGH_FRAMES and now.published == before.published:
        return Health(HealthLevel.WARN, f"nothing usable arrives: {_main_reason(before, now)}")
    if finding:
        return Health(HealthLevel.WARN, finding)
    return Health(HealthLevel.OK, "data arrives")


def _main_reason(before: CountsSnapshot, now: CountsSnapshot) -> str:
    grown = {reason: n - before.by_reason.get(reason, 0) for reason, n in now.by_reason.items()}
    reason = max(grown, key=lambda name: grown[name])
    return f"{reason}: {REASONS.get(reason, reason)}"
