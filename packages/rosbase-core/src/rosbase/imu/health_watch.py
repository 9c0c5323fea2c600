"""Judge an active reader by its samples. Pure: the caller gives the time, a few times a second."""

from collections.abc import Callable, Mapping

from rosbase.contracts.transport import TransportHealth, TransportState
from rosbase.imu.counts import CountsSnapshot
from rosbase.imu.health import Health, HealthLevel, without_figures
from rosbase.imu.rejects import NO_SIGN_OF_LIFE, meaning_of

__all__ = ["HealthWatch", "device_fault"]

_NS_PER_S = 1_000_000_000
_DAMAGE = "framing_error"
_ERROR_AFTER = 5.0
# A device that sends nonsense now and then is not silent in between: it is after so many times
# the interval at which it sends, but no later than this.
_USUAL_INTERVALS = 2.5
_LONGEST_INTERVALS_S = 60.0
# Another reason is the commonest one when it leads by so much. Two that take turns never do.
_LEAD_RATIO = 1.25
_LEAD_FRAMES = 4


class HealthWatch:
    """Judges an active reader from its counts.

    The health is OK as long as the last sample was published within the stale timeout.
    Otherwise it is the most common reason for refused frames since then, or silence if no data
    has come.
    """

    def __init__(
        self,
        stale_timeout_s: float,
        now_ns: int,
        counts: CountsSnapshot,
        explain: Callable[[str], str] = meaning_of,
    ) -> None:
        """Start at activation.

        Args:
            stale_timeout_s: Seconds without a sample after which the health is not OK.
            now_ns: Time of the activation on the monotonic clock.
            counts: Counts so far.
            explain: Returns the explanation of a reason; empty if there is none.
        """
        self._stale_s = stale_timeout_s
        self._explain = explain
        self._published = counts.published
        self._has_sample = False
        # When a sample and data came last, or else when it was activated.
        self._sample_ns = self._data_ns = now_ns
        self._has_new_data = False
        self._interval_ns = 0
        self._framed = _framed(counts)
        # When data came first since the last frame.
        self._unframed_ns: int | None = None
        # Reasons are counted since the last sample.
        self._since: Mapping[str, int] = counts.by_reason
        self._reason = ""
        # Framing errors so far, and at the last sample.
        self._damaged = 0
        self._damaged_since: int | None = None
        self._is_unended = False
        self.unended = 0
        """Number of frames that began and did not end within the stale timeout."""

    def look(
        self, now_ns: int, counts: CountsSnapshot, transport: TransportHealth, finding: str = ""
    ) -> Health:
        """Return the health at this moment.

        Args:
            now_ns: The monotonic clock.
            counts: Counts of the frames so far.
            transport: Health of the transport.
            finding: Fault of the published samples; empty if none.
        """
        self._note(now_ns, counts, transport)
        if transport.last_error or transport.state is TransportState.RECONNECTING:
            return device_fault(transport)
        if (now_ns - self._sample_ns) / _NS_PER_S > self._stale_s:
            return self._judge_no_samples(now_ns, counts, transport)
        if finding:
            return Health(HealthLevel.WARN, finding)
        message = "samples arrive" if self._has_sample else "waiting for the first sample"
        return Health(HealthLevel.OK, message)

    def _note(self, now_ns: int, counts: CountsSnapshot, transport: TransportHealth) -> None:
        """Note the times at which data came."""
        data_ns = max(self._data_ns, transport.last_data_ns or 0)
        self._has_new_data = data_ns > self._data_ns
        if self._has_new_data:
            self._interval_ns = data_ns - self._data_ns
            self._data_ns = data_ns
            self._unframed_ns = self._unframed_ns or data_ns
        self._damaged = transport.link_errors.get(_DAMAGE, 0)
        if self._damaged_since is None or counts.published != self._published:
            self._damaged_since = self._damaged
        framed = _framed(counts)
        if framed != self._framed:
            self._framed, self._unframed_ns, self._is_unended = framed, None, False
        if counts.published != self._published:
            # A sample may have come after the transport was asked, and before it was counted.
            self._sample_ns = data_ns if self._has_new_data else now_ns
            self._published, self._has_sample = counts.published, True
            self._count_from(counts, "")

    def _judge_no_samples(
        self, now_ns: int, counts: CountsSnapshot, transport: TransportHealth
    ) -> Health:
        silence_s = (now_ns - self._data_ns) / _NS_PER_S
        has_sent = self._data_ns > self._sample_ns
        is_sending = has_sent and (self._has_new_data or silence_s <= self._stale_s)
        if is_sending and self._has_no_frames():
            self._note_no_frames(counts, transport)
        reason = self._commonest_reason(counts)
        is_silent = silence_s > self._patience_s(has_sent=has_sent)
        if reason and not is_silent:
            damaged = self._damaged - (self._damaged_since or 0)
            return _unusable(reason, self._explain(reason), transport.pending_bytes, damaged)
        if is_sending:
            return _no_sample((now_ns - self._sample_ns) / _NS_PER_S)
        return _silence(silence_s, is_long=is_silent)

    def _has_no_frames(self) -> bool:
        """Return whether data has come for some time without a single frame."""
        unframed_ns = self._unframed_ns
        # A line may take a moment to arrive.
        least_ns = self._stale_s * _NS_PER_S / 2
        return unframed_ns is not None and self._data_ns - unframed_ns >= least_ns

    def _note_no_frames(self, counts: CountsSnapshot, transport: TransportHealth) -> None:
        if transport.pending_bytes:
            self._count_from(counts, "unended")
            self.unended += not self._is_unended
            self._is_unended = True
        else:
            self._count_from(counts, "no_frame")

    def _commonest_reason(self, counts: CountsSnapshot) -> str:
        """Return why most frames since the last sample were refused; empty if none was."""
        grown = {
            reason: number - self._since.get(reason, 0)
            for reason, number in counts.by_reason.items()
            if reason not in NO_SIGN_OF_LIFE and reason != "unended"
        }
        most = max(grown, key=grown.__getitem__, default="")
        least = _LEAD_RATIO * grown.get(self._reason, 0) + _LEAD_FRAMES if self._reason else 0
        if most and grown[most] > least:
            self._reason = most
        return self._reason

    def _count_from(self, counts: CountsSnapshot, reason: str) -> None:
        """Count reasons from now on; until another one leads, this one counts."""
        self._since, self._reason = counts.by_reason, reason

    def _patience_s(self, *, has_sent: bool) -> float:
        """Return how long a device may be silent before that is an error."""
        usual_s = _USUAL_INTERVALS * self._interval_ns / _NS_PER_S if has_sent else 0.0
        return max(_ERROR_AFTER * self._stale_s, min(usual_s, _LONGEST_INTERVALS_S))


def _framed(counts: CountsSnapshot) -> int:
    """Return how many frames have ended, with any outcome."""
    return counts.received - counts.by_reason.get("unended", 0)


def device_fault(transport: TransportHealth) -> Health:
    """Return the health of a reader whose device is absent, or was a moment ago."""
    error = transport.last_error
    message = error
    if transport.state is TransportState.RECONNECTING:
        message = f"waiting for the device: {error}" if error else "waiting for the device"
    # Away or just back, it is the same fault; a device that comes and goes is said once.
    return Health(HealthLevel.ERROR, message, kind=f"device: {without_figures(error)}")


def _silence(seconds: float, *, is_long: bool) -> Health:
    """Return the health of a reader whose device sends nothing."""
    level = HealthLevel.ERROR if is_long else HealthLevel.WARN
    return Health(level, f"no data for {seconds:.1f} s")


def _no_sample(seconds: float) -> Health:
    """Return the health of a reader whose device sends, while the fault is not known yet."""
    return Health(HealthLevel.WARN, f"no sample for {seconds:.1f} s")


def _unusable(reason: str, why: str, pending_bytes: int, damaged: int) -> Health:
    """Return the health of a reader whose device sends, but no samples.

    Args:
        reason: Why most frames are refused, in one word.
        why: The same in half a line, or an empty text.
        pending_bytes: Bytes since the last end of a frame, which are the fault if `unended`.
        damaged: Bytes with framing errors since the last sample, which are the true cause.
    """
    if reason == "unended" and pending_bytes:
        why = f"{pending_bytes} {why}"
    said = f"nothing usable arrives: {reason}"
    if damaged:
        said = f"{said}, with framing errors"
        why = f"{damaged} bytes as if sent at another baud rate"
    return Health(HealthLevel.WARN, f"{said}: {why}" if why else said, kind=said)
