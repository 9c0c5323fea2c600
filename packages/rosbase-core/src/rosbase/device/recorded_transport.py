"""A transport whose calls, frames and health are recorded."""

from collections.abc import Callable
from functools import partial
from threading import Event

from attrs import evolve

from rosbase.clock import Clock
from rosbase.contracts.transport import Transport, TransportContext, TransportHealth
from rosbase.device.conducted_calls import ConductedTransport, Reading
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind

__all__ = ["RecordedTransport"]

# As long as Python's switch interval may delay the reader anyway.
_ANSWER_S = 0.005


class RecordedTransport(ConductedTransport):
    """Lets the frames of a transport come into the program one by one, and notes them.

    The transport itself knows nothing of it. It has the clock of the machine, so it stamps frames
    on its own thread as ever, and a logger of its own, so its throttles are not the program's.
    """

    def __init__(
        self,
        conductor: Conductor,
        name: str,
        create: Callable[[TransportContext], Transport],
        context: TransportContext,
    ) -> None:
        """Make the transport.

        Raises:
            ConfigurationError: `create` raised it.
        """
        super().__init__(conductor, name, context)
        self._create = create
        clock: Clock = getattr(conductor.clock, "machine", conductor.clock)
        self._inner_context = evolve(context, clock=clock, logger=context.logger.twin(clock))
        self._section("create")

    def _call(self, op: str, reading: Reading | None) -> None:
        if op == "create":
            self._inner = self._create(self._inner_context)
        elif reading is not None:
            self._inner.start(partial(self._arrived, reading))
        else:
            getattr(self._inner, op)()

    def _is_open_now(self) -> bool:
        return self._inner.is_open

    def _health_now(self) -> TransportHealth:
        return self._inner.health

    def _arrived(self, reading: Reading, frame: bytes, stamp_ns: int) -> bool | None:
        """Let a frame come in, and return whether it gave a sample; None if that takes long.

        Called on the reader thread. While a long tick runs, the frame waits, and the reader does
        not.
        """
        frame = frame if type(frame) is bytes else bytes(frame)
        handing = _Handing()
        run = partial(self._hand_over, handing, reading, frame, stamp_ns)
        self._conductor.come_in(Kind.FRAME, (reading.number, stamp_ns), frame, run)
        return handing.answer if handing.is_done else handing.wait()

    def _hand_over(
        self, handing: "_Handing", reading: Reading, frame: bytes, stamp_ns: int
    ) -> None:
        try:
            handing.answer = self._take(reading, frame, stamp_ns)
        finally:
            handing.end()


class _Handing:
    """A frame on its way into the program, and the answer on its way back."""

    __slots__ = ("_event", "answer", "is_done")

    def __init__(self) -> None:
        self.answer: bool | None = None
        self.is_done = False
        self._event: Event | None = None

    def end(self) -> None:
        """Note that there is an answer."""
        self.is_done = True
        # Usually nobody waits, and an event costs as much as all else.
        if self._event is not None:
            self._event.set()

    def wait(self) -> bool | None:
        """Wait a moment for the answer, and return it."""
        self._event = event = Event()
        # Looked at only now: whoever came before this line has not seen the event.
        if not self.is_done:
            event.wait(_ANSWER_S)
        return self.answer
