"""The intake: turns bytes into frames with stamps, and hands them over."""

from collections.abc import Callable
from typing import Any, TypeAlias

from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import OnFrame, Tally, TransportContext, hand_over
from rosbase.device.device import Device
from rosbase.framing import Frame, FrameEvent, Framer

__all__ = ["Intake", "ReadMore"]

ReadMore: TypeAlias = Callable[[float], bytes]
"""Function that waits for more data, for a number of milliseconds.

It returns the data; empty if none came.
"""

# After a stall, all that waits is read before any of it is stamped. A terminal hands a long queue
# over in pieces, with pauses of some 0.1 ms in which it looks empty.
_SETTLE_MS = 1
# More than a terminal or a socket keeps by default. What is beyond that waits for the next look.
_MOST_BYTES = 512 * 1024


class Intake:
    """Splits data into frames, stamps them and hands them over, all on the reader thread."""

    def __init__(
        self,
        framer: Framer | None,
        on_frame: OnFrame,
        context: TransportContext,
        tally: Tally,
        stamper: Stamper,
    ) -> None:
        """Prepare to hand frames to `on_frame`."""
        self._framer = framer
        # A framer need not know whether it is within a frame.
        self._telling: Any = framer if hasattr(framer, "pending_bytes") else None
        self._on_frame = on_frame
        self._logger = context.logger
        self._tally = tally
        self._stamper = stamper
        self._read_now, self._stamp_one = stamper.read, stamper.one
        self._byte_ns: float | None = None
        self.is_ended = False
        """Whether nothing more may be handed over."""

    def begin(self, device: Device) -> None:
        """Prepare for later data of that device."""
        bytes_per_s = getattr(device, "bytes_per_s", None)
        self._byte_ns = 1e9 / bytes_per_s if bytes_per_s else None
        if self._framer is not None:
            self._framer.reset()

    def take(self, data: bytes, read_more: ReadMore) -> int:
        """Hand over the frames that the data completes; return the moment at which it was read.

        Args:
            data: Data that has just been read.
            read_more: Reads the data that waits behind it.
        """
        at_ns = self._read_now()
        tally, framer = self._tally, self._framer
        tally.last_data_ns = at_ns
        tally.received_bytes += len(data)
        events: list[FrameEvent]
        events = [Frame(data, at_ns)] if framer is None else framer.feed(data, at_ns)
        if len(events) == 1 and not self.is_ended:
            (event,) = events
            # The usual case: one frame, and no other one begun in the same read.
            if isinstance(event, Frame) and (event.stamp_ns < at_ns or not self._is_within):
                stamp_ns = self._stamp_one(event.stamp_ns)
                if stamp_ns is not None:
                    tally.frames += 1
                    hand_over(self._on_frame, event.data, stamp_ns, self._logger)
                    return at_ns
        if events or self._stamper.wants_more:
            self._take_many(events, len(data), read_more)
        return at_ns

    @property
    def _is_within(self) -> bool:
        """Whether a frame has begun but is not complete."""
        return self._telling is not None and self._telling.pending_bytes > 0

    def _take_many(self, events: list[FrameEvent], size: int, read_more: ReadMore) -> None:
        try:
            if self._stamper.wants_more:
                size += self._read_on(events, read_more)
        finally:
            # Also if the device was lost behind them.
            if events:
                self._hand_over(events, size)

    def _read_on(self, events: list[FrameEvent], read_more: ReadMore) -> int:
        """Add waiting data to the events; return its number of bytes."""
        size = 0
        while size < _MOST_BYTES and self._stamper.wants_more and not self.is_ended:
            # One frame alone has usually just come.
            data = read_more(_SETTLE_MS if len(events) > 1 else 0)
            if not data:
                break
            size += len(data)
            at_ns = self._tally.last_data_ns = self._stamper.more()
            self._tally.received_bytes += len(data)
            framer = self._framer
            events += [Frame(data, at_ns)] if framer is None else framer.feed(data, at_ns)
        return size

    def _hand_over(self, events: list[FrameEvent], size: int) -> None:
        byte_ns, tally = self._byte_ns, self._tally
        stamps = self._stamper.many(
            [event.stamp_ns for event in events],
            is_within=self._is_within,
            wire_ns=None if byte_ns is None else int(byte_ns * size / len(events)),
        )
        for event, stamp_ns in zip(events, stamps, strict=True):
            if self.is_ended:
                return
            if stamp_ns is None:
                # It has been counted as late.
                continue
            if isinstance(event, Frame):
                tally.frames += 1
                hand_over(self._on_frame, event.data, stamp_ns, self._logger)
            else:
                tally.count_error(event.reason)
