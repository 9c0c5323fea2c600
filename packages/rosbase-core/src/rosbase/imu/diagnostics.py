"""Diagnostics of the reader on `/diagnostics`, once a second, in every state."""

from collections.abc import Iterator
from typing import Protocol

from rosbase.clock import Clock
from rosbase.contracts.backend import timer_period_ns
from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.transport import TransportHealth
from rosbase.imu.counts import CountsSnapshot
from rosbase.imu.health import Health
from rosbase.imu.settings import ReaderSettings
from rosbase.lifecycle import CallbackReturn, State, TransitionEvent
from rosbase.messages import DiagnosticArray, DiagnosticStatus, Header, KeyValue
from rosbase.runtime.executor import Executor
from rosbase.text.printable import MOST_PROSE, printable

__all__ = ["DIAGNOSTICS_TOPIC", "Diagnostics"]

DIAGNOSTICS_TOPIC = "/diagnostics"
"""Topic that the tools of ROS read (REP-107)."""

_PERIOD_S = 1.0
_DEPTH = 10
_NS_PER_S, _NS_PER_MS = 1_000_000_000, 1_000_000
_SUCCESS = CallbackReturn.SUCCESS.label


class _Reader(Protocol):
    """Properties of a reader that the diagnostics report."""

    last_error: BaseException | None

    def get_state(self) -> State: ...

    def check_health(self) -> Health: ...

    @property
    def counts(self) -> CountsSnapshot: ...

    @property
    def transport_health(self) -> TransportHealth: ...

    @property
    def settings(self) -> ReaderSettings: ...


class Diagnostics:
    """Publishes a status of the reader once a second, until the backend is closed.

    It does not use a lifecycle publisher: users must see that a device cannot be opened while
    the reader is unconfigured.
    """

    def __init__(self, reader: _Reader, node: NodeConnection, executor: Executor) -> None:
        """Start publishing.

        Args:
            reader: The reader.
            node: Its connection.
            executor: Calls it once a second, on the clock of the machine.
        """
        self._reader = reader
        self._clock: Clock = node.clock
        self._name = f"{node.node_name}: IMU"
        self._failure = ""
        self._published = self._rejected = 0
        self._reported_ns = self._clock.monotonic_ns()
        self._publish = node.create_publisher(DiagnosticArray, DIAGNOSTICS_TOPIC, _DEPTH).publish
        # They go on while a simulation stands still.
        executor.create_timer(timer_period_ns(_PERIOD_S), self._report)

    def note(self, event: TransitionEvent) -> None:
        """Take a step of the lifecycle. This is a listener of its transitions."""
        label = event.transition.label
        if event.transition.is_public and event.transition.id:
            self._failure = ""
        elif label != _SUCCESS or event.start is State.ERRORPROCESSING:
            self._failure = str(self._reader.last_error or label)

    def _report(self) -> None:
        self._publish(DiagnosticArray(Header(self._clock.now()), (self._status(),)))

    def _status(self) -> DiagnosticStatus:
        # Judged now: half a period later, a first sample would be news of the second before.
        state, health = self._reader.get_state(), self._reader.check_health()
        if state is State.ACTIVE:
            level, message = int(health.level), health.message
        elif self._failure:
            level, message = DiagnosticStatus.ERROR, f"{state.label}: {self._failure}"
        else:
            level, message = DiagnosticStatus.OK, state.label
        settings = self._reader.settings
        return DiagnosticStatus(
            level=level,
            name=self._name,
            # What an error says is anybody's text, and must not end the reader.
            message=printable(message, MOST_PROSE),
            hardware_id=printable(settings.device),
            values=tuple(
                KeyValue(printable(key), printable(value, MOST_PROSE))
                for key, value in self._values(state, settings)
            ),
        )

    def _values(self, state: State, settings: ReaderSettings) -> Iterator[tuple[str, str]]:
        counts, transport = self._reader.counts, self._reader.transport_health
        now_ns = self._clock.monotonic_ns()
        yield "state", state.label
        yield "transport", f"{settings.transport.name} {transport.state.value}"
        published_hz, rejected_hz = self._rates_hz(counts, now_ns)
        yield "rate (Hz)", f"{published_hz:.1f}"
        yield "rejected rate (Hz)", f"{rejected_hz:.1f}"
        if transport.last_data_ns is not None:
            yield "last data (s ago)", f"{(now_ns - transport.last_data_ns) / _NS_PER_S:.1f}"
        yield "published", str(counts.published)
        yield "rejected", str(counts.rejected)
        yield "ignored", str(counts.ignored)
        for reason, number in sorted(counts.by_reason.items()):
            yield reason, str(number)
        for reason, number in sorted(counts.left_out.items()):
            yield f"left out: {reason}", str(number)
        yield "time unusable", str(counts.time_unusable)
        yield "usual interval (ms)", f"{transport.interval_ns / _NS_PER_MS:.3f}"
        yield "arrival jitter (ms)", f"{transport.jitter_ns / _NS_PER_MS:.3f}"
        yield "clock steps", str(transport.clock_steps)
        yield "late frames", str(transport.late_frames)
        for reason, number in sorted(transport.link_errors.items()):
            yield f"link: {reason}", str(number)
        yield "clock unusable", str(counts.clock_unusable)
        yield "reconnects", str(transport.reconnects)
        yield "last error", transport.last_error

    def _rates_hz(self, counts: CountsSnapshot, now_ns: int) -> tuple[float, float]:
        """Return how many samples were published and how many frames were rejected, per second."""
        per_s = _NS_PER_S / max(1, now_ns - self._reported_ns)
        published, rejected = counts.published, counts.rejected
        rates = (published - self._published) * per_s, (rejected - self._rejected) * per_s
        self._published, self._rejected, self._reported_ns = published, rejected, now_ns
        return rates
