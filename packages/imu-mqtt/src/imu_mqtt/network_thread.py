"""The thread that keeps a connection to the broker as long as one is wanted."""

import select
import threading
from collections import Counter
from contextlib import suppress
from typing import Any

from imu_mqtt.config import MqttConfig
from imu_mqtt.connection import Connection
from imu_mqtt.dialing import RefusedError
from imu_mqtt.subscription import Subscription
from rosbase import (
    Backoff,
    Stamper,
    Tally,
    TransportContext,
    TransportError,
    WakePipe,
    background_thread,
)

__all__ = ["NetworkThread"]

_TURN_S, _TURN_NS = 0.5, 500_000_000
# After a stall, how long to wait for what comes behind the messages that have waited.
_SETTLE_S = 0.001
# So many are read at once at most, for meanwhile, and while they are handed over, nobody answers
# the broker's pings.
_MOST_AT_ONCE = 1_500
# Who was refused will be so for some time.
_SLOW_S = 5.0
# So is, less surely, who was thrown out again and again: the broker may just have been restarted.
_SLOWER_S = 1.5
# A connection that lasted so long was no mistake; so many that did not, in a row, are one.
_PROVED_NS = 5_000_000_000
_MANY_ENDS = 3
# More different reasons than these, in a row, are words that the broker makes up.
_MANY_REASONS = 8


class NetworkThread:
    """Connects, subscribes on request, and starts again when the connection ends.

    Only this thread touches the connection. Other threads set their wishes, and wake it.
    """

    def __init__(
        self, config: MqttConfig, context: TransportContext, tally: Tally, stamper: Stamper
    ) -> None:
        """Prepare to connect."""
        self._config = config
        self._context = context
        self._tally = tally
        self._stamper = stamper
        # When the network was last looked at, and whether that look goes on with the next.
        self._looked_ns = 0
        self._reads_on = False
        self._wanted: Subscription | None = None
        self._made: Subscription | None = None
        self._connection: Connection | None = None
        self._stopping = False
        self._backoff = Backoff()
        self._slower, self._slow = Backoff(_SLOWER_S, _SLOWER_S), Backoff(_SLOW_S / 2, _SLOW_S)
        self._early_ends = 0
        self._said: Counter[str] = Counter()
        self._has_complained = False
        self._proved_from_ns = 0
        self._is_proved = False
        self._was_connected = False
        self._is_let_in = False
        self._is_reported = False
        self.is_connected = False
        """Whether there is a connection at this moment."""
        self._is_tried = threading.Event()
        self._failure: TransportError | None = None
        self._wakeup = WakePipe()
        self._has_ended = False
        self._thread = background_thread(self._run, "imu-mqtt")

    def start(self) -> None:
        """Start the thread."""
        try:
            self._thread.start()
        except RuntimeError:
            self._wakeup.close()
            raise

    @property
    def is_current_thread(self) -> bool:
        """Whether the caller runs on this thread, which means within `on_frame`."""
        return threading.current_thread() is self._thread

    @property
    def is_stopping(self) -> bool:
        """Whether the thread has ended or was asked to."""
        return self._stopping or self._has_ended

    def await_attempt(self, timeout_s: float) -> TransportError | None:
        """Wait for the first attempt to connect; return the reason if it failed.

        There is no other attempt after that, unless `wait_for_broker` is set.
        """
        if not self._is_tried.wait(timeout_s):
            return TransportError(f"no answer from {self._config.address}")
        return self._failure

    def want(self, subscription: Subscription | None) -> None:
        """Set the subscription that is wanted from now on, if any."""
        self._wanted = subscription
        if subscription is not None and not self.is_connected:
            # Made when there is a connection; nobody need wait for that.
            subscription.answer()
        self._wakeup.wake()

    def request_stop(self) -> None:
        """Ask the thread to disconnect and end."""
        self._stopping = True
        self._wakeup.wake()

    def join(self, timeout_s: float) -> bool:
        """Wait for the end; return whether it came in time."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    # On the thread.

    def _run(self) -> None:
        try:
            while not self._stopping:
                self._sleep(self._connect_and_serve())
        except BaseException as error:
            self._tally.last_error = f"the reader failed: {error!r}"
            self._failure = TransportError(self._tally.last_error)
            self._context.logger.error(self._tally.last_error, exc_info=error)
        finally:
            self._has_ended = True
            self._wakeup.close()
            self._is_tried.set()

    def _connect_and_serve(self) -> float:
        """Serve one connection from beginning to end; return how long to wait after it."""
        try:
            self._connection = Connection(
                self._config,
                self._context.clock,
                self._take,
                lambda: not self._stopping,
                self._look,
            )
            self._connection.open()
            self._is_let_in = True
            if self._wanted is not None:
                # Before it is said to be back: a broker may let us in, and not read.
                self._resubscribe(self._connection)
            self._note_connected()
            self._serve(self._connection)
        except TransportError as error:
            return 0.0 if self._stopping else self._note_end(error)
        finally:
            self._end_connection()
        return 0.0

    def _serve(self, connection: Connection) -> None:
        connection.watch(self._wakeup.fileno())
        while not self._stopping:
            if self._wanted is not self._made:
                self._resubscribe(connection)
            if not self._turn(connection):
                raise TransportError(connection.end)
            self._wakeup.drain()
            if not self._is_proved and self._context.clock.monotonic_ns() > self._proved_from_ns:
                self._note_proved()

    def _turn(self, connection: Connection) -> bool:
        """Hand over all arrived messages together; return whether the connection still stands."""
        subscription, stamper = self._made, self._stamper
        until_ns = self._context.clock.monotonic_ns() + _TURN_NS
        try:
            stands = connection.turn(_TURN_S)
            if subscription is None or not subscription.kept:
                stamper.look(until_ns)
            elif stamper.wants_more:
                stands = stands and self._read_on(connection, subscription)
        finally:
            # Also if the connection was lost behind them.
            if subscription is not None:
                subscription.deliver(self._looked_ns)
        return stands

    def _read_on(self, connection: Connection, subscription: Subscription) -> bool:
        """Read all waiting data; return whether the connection still stands."""
        self._reads_on = True
        try:
            kept, stands = 0, True
            while stands and kept < subscription.kept < _MOST_AT_ONCE:
                if self._stopping or not self._stamper.wants_more:
                    break
                kept = subscription.kept
                stands = connection.turn(_SETTLE_S)
        finally:
            self._reads_on = False
        return stands

    def _look(self) -> None:
        self._looked_ns = self._stamper.more() if self._reads_on else self._stamper.read()

    def _resubscribe(self, connection: Connection) -> None:
        wanted = self._wanted
        if self._made is not None:
            self._made = None
            connection.unsubscribe()
        if wanted is None:
            return
        try:
            connection.subscribe()
        except RefusedError as error:
            if wanted.answer(error) and not self._config.wait_for_broker:
                # Whoever starts it is told, and decides.
                self._is_reported = True
            raise
        # What came before the broker's answer was sent before, to the last subscription.
        self._made = wanted
        self._stamper.begin()
        wanted.answer()

    def _take(self, message: Any) -> None:
        if self._made is not None:
            self._made.take(
                message.payload,
                self._looked_ns,
                topic=message.topic,
                retained=message.retain,
                redelivered=message.dup,
                fault=message.fault,
                size=message.size,
            )

    def _note_connected(self) -> None:
        self.is_connected = True
        self._tally.reconnects += self._was_connected
        if self._early_ends < _MANY_ENDS:
            self._say_connected()
        self._was_connected = True
        self._is_proved = False
        self._proved_from_ns = self._context.clock.monotonic_ns() + _PROVED_NS
        self._is_tried.set()

    def _note_proved(self) -> None:
        """Note that the connection has lasted."""
        self._is_proved = True
        if self._early_ends >= _MANY_ENDS:
            self._say_connected()
        self._early_ends = 0
        self._said.clear()
        for backoff in (self._backoff, self._slower, self._slow):
            backoff.reset()

    def _note_end(self, error: TransportError) -> float:
        """Log why there is no connection; return how long to wait before the next."""
        if not self._was_connected:
            self._failure = self._failure or error
            # Whoever opens is told, and decides.
            self._stopping = not self._config.wait_for_broker
        self._is_tried.set()
        if self._stopping:
            return 0.0
        if isinstance(error, RefusedError):
            if self._is_reported:
                self._tally.last_error = str(error)
            else:
                self._say(str(error))
            self._is_reported = False
            return self._slow.next_s()
        # A broker that cannot be reached throws nobody out.
        self._early_ends = self._early_ends + (not self._is_proved) if self._is_let_in else 0
        if self._early_ends >= _MANY_ENDS:
            # Not the reason, which alternates: it has been said, and this is to be said once.
            config = self._config
            who = f"another client {config.client_id!r}, or a broker that restarts"
            self._say(
                f"the connection to {config.address} is lost again and again: is there {who}?"
            )
            return self._slower.next_s()
        self._say(str(error))
        return self._backoff.next_s()

    def _end_connection(self) -> None:
        self.is_connected = self._is_let_in = False
        made, self._made = self._made, None
        connection, self._connection = self._connection, None
        if connection is not None:
            if made is not None:
                # Whatever comes of it, it is over.
                with suppress(Exception):
                    connection.unsubscribe()
            connection.close()
        wanted = self._wanted
        if wanted is not None:
            wanted.answer()

    def _sleep(self, seconds: float) -> None:
        """Wait, unless the thread must end."""
        wakeup = select.poll()
        wakeup.register(self._wakeup, select.POLLIN)
        deadline_ns = self._context.clock.monotonic_ns() + int(seconds * 1e9)
        while not self._stopping:
            left_ns = deadline_ns - self._context.clock.monotonic_ns()
            if left_ns <= 0:
                return
            wakeup.poll(left_ns / 1e6)
            self._wakeup.drain()

    def _say_connected(self) -> None:
        self._tally.last_error = ""
        if self._has_complained or not self._was_connected:
            state = "back at" if self._was_connected else "connected to"
            self._context.logger.info(f"{state} {self._config.address}")
        self._has_complained = False

    def _say(self, reason: str) -> None:
        """Log why there is no data, once for each reason in a row.

        Until a connection lasts, log no more than a few times, because reasons may
        alternate or differ each time.
        """
        if reason not in self._said and len(self._said) >= _MANY_REASONS:
            address = self._config.address
            reason = f"the connection to {address} keeps failing, each time for another reason"
        if reason == self._tally.last_error:
            return
        self._tally.last_error = reason
        self._said[reason] += 1
        if self._said[reason] <= _MANY_ENDS:
            self._has_complained = True
            self._context.logger.warning(f"{reason}; trying again")
