"""The plug of a simulated device: pulled once during a run, and put back."""

from enum import Enum

from rosbase.contracts.transport import PluggableDevice, TransportState
from rosbase.imu.reader import ImuReader
from rosbase.imu.simulator import ImuSimulator

__all__ = ["PlugPull"]


class _Phase(Enum):
    BEFORE = "before"
    DRAINING = "draining"
    OUT = "out"
    RETURNING = "returning"
    SENDING = "sending"
    AFTER = "after"


class PlugPull:
    """Pulls the plug when the reader has all sent samples, and puts it back.

    The device sends only while it is plugged in and open. So nothing is lost that could have
    arrived, and the counts agree in every run.
    """

    def __init__(
        self,
        device: PluggableDevice,
        simulator: ImuSimulator,
        reader: ImuReader,
        *,
        at_s: float,
        out_s: float,
    ) -> None:
        """Prepare to pull the plug at `at_s` seconds of the run, for `out_s` seconds."""
        self._device = device
        self._simulator = simulator
        self._reader = reader
        self._at_s, self._out_s = at_s, out_s
        self._phase = _Phase.BEFORE
        self._pulled_s = self._now_s = 0.0
        self._reconnects = self._sent = 0
        self.was_out_s: float | None = None
        """Seconds without samples; None until they come again."""

    @property
    def is_busy(self) -> bool:
        """Whether the pull has begun and is not over."""
        return self._phase not in (_Phase.BEFORE, _Phase.AFTER)

    def step(self, now_s: float) -> None:
        """Do the work that is due at that moment of the run, in seconds."""
        self._now_s = now_s
        sent, received = self._simulator.sent, self._reader.counts.received
        if self._phase is _Phase.BEFORE and now_s >= self._at_s:
            self._simulator.stop()
            self._phase = _Phase.DRAINING
        elif self._phase is _Phase.DRAINING and received >= sent:
            self._pull()
        elif self._phase is _Phase.OUT and now_s >= self._pulled_s + self._out_s:
            self._device.replug()
            self._phase = _Phase.RETURNING
        elif self._phase is _Phase.RETURNING and self._is_open:
            self._simulator.start()
            self._sent = sent
            self._phase = _Phase.SENDING
        elif self._phase is _Phase.SENDING and received > self._sent:
            self.was_out_s = now_s - self._pulled_s
            self._phase = _Phase.AFTER

    @property
    def note(self) -> tuple[str, str]:
        """Sentence on the plug, and its colour; empty before the pull."""
        if self._phase in (_Phase.BEFORE, _Phase.DRAINING):
            return "", ""
        if self.was_out_s is not None:
            return f"plugged in again: back after {self.was_out_s:.1f} s, nothing lost", "green"
        out_s = self._now_s - self._pulled_s
        if self._phase is _Phase.OUT:
            return f"unplugged {out_s:.1f} s ago: the reader waits for the device", "yellow"
        return f"plugged in after {out_s:.1f} s: the reader opens the device again", "yellow"

    def _pull(self) -> None:
        self._pulled_s = self._now_s
        self._reconnects = self._reader.transport_health.reconnects
        self._device.unplug()
        self._phase = _Phase.OUT

    @property
    def _is_open(self) -> bool:
        health = self._reader.transport_health
        is_connected = health.state is TransportState.CONNECTED
        return is_connected and health.reconnects > self._reconnects
