"""Checks of random histories of calls and events against a model of the transport."""

from collections.abc import Callable

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    precondition,
    rule,
    run_state_machine_as_test,
)

from rosbase.contracts.transport import TransportState
from rosbase.testing.promise import BrokenPromiseError
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check

__all__ = ["HistoryChecks", "Machine"]


class HistoryChecks(TransportAuthor):
    """Checks of random histories."""

    @check()
    def test_every_history_ends_where_the_model_says(self, bench: Bench) -> None:
        """After any history of calls, data, junk and losses, its state is that of the model."""
        failures: list[BrokenPromiseError] = []

        class History(Machine):
            def __init__(self) -> None:
                super().__init__(Bench(bench.author, bench.promise), failures)

        try:
            run_state_machine_as_test(
                History,
                settings=settings(
                    max_examples=self.machine_examples,
                    stateful_step_count=self.machine_steps,
                    deadline=None,
                    database=None,
                    # On a real link, the first report of a failure counts.
                    phases=[Phase.generate],
                    suppress_health_check=list(HealthCheck),
                ),
            )
        except BaseException:
            if not failures:
                raise
        if failures:
            raise failures[0]


# States that chance reaches too seldom, and steps that often fail after them.
_BEGINNINGS = (
    "",
    "start",
    "start start",
    "open stop",
    "start junk stop",
    "start half stop",
    "start half close",
    "start unplug close replug",
    "start unplug stop",
)


class Machine(RuleBasedStateMachine):
    """Transport with the few words of its model."""

    def __init__(self, bench: Bench, failures: list[BrokenPromiseError]) -> None:
        super().__init__()
        self._bench = bench
        self._failures = failures
        self._history: list[str] = []
        self._peer = bench.peer()
        self._transport = bench.transport(self._peer)
        self._subscriber = RecordingSubscriber()
        self._numbers = iter(range(9_000))
        self.can = bench.author.capabilities
        # The model.
        self.is_plugged = True
        self.is_open = self.is_started = False
        # A loss is noticed while it reads; before that, it may hold a device that is gone.
        self.is_in_doubt = False
        self.is_spoiled = False

    @initialize(beginning=st.sampled_from(_BEGINNINGS))
    def begin(self, beginning: str) -> None:
        """Return a start of a history, as far as the capabilities allow."""
        able = {"junk": self.can.is_stream, "half": self.can.is_stream}
        able |= {"unplug": self.can.can_unplug, "replug": self.can.can_unplug}
        for name in beginning.split():
            if able.get(name, True):
                self._take(getattr(self, f"_{name}"))

    @rule()
    def open(self) -> None:
        """Make the call."""
        self._take(self._open)

    @rule()
    def start(self) -> None:
        """Make the call."""
        self._take(self._start)

    @rule()
    def stop(self) -> None:
        """Make the call."""
        self._take(self._stop)

    @rule()
    def close(self) -> None:
        """Make the call."""
        self._take(self._close)

    @precondition(lambda self: self.is_plugged)
    @rule()
    def data(self) -> None:
        """Send from the device."""
        self._take(self._data)

    @precondition(lambda self: self.is_plugged and self.is_started and self.can.is_stream)
    @rule()
    def junk(self) -> None:
        """Disturb the line."""
        self._take(self._junk)

    @precondition(lambda self: self.is_plugged and self.is_started and self.can.is_stream)
    @rule()
    def half(self) -> None:
        """Begin a frame."""
        self._take(self._half)

    @precondition(lambda self: self.is_plugged and self.can.can_unplug)
    @rule()
    def unplug(self) -> None:
        """Unplug the device."""
        self._take(self._unplug)

    @precondition(lambda self: not self.is_plugged)
    @rule()
    def replug(self) -> None:
        """Plug the device in again."""
        self._take(self._replug)

    def teardown(self) -> None:
        """End the history."""
        self._bench.close()

    def _take(self, step: Callable[[], None]) -> None:
        """Make one step, and compare the result with the model."""
        self._history.append(step.__name__.removeprefix("_"))
        try:
            step()
            self._look()
        except BrokenPromiseError as error:
            self._failures.append(
                BrokenPromiseError(f"{error}\n  history:  {', '.join(self._history)}")
            )
            raise

    def _open(self) -> None:
        if self.is_plugged:
            self._transport.open()
            self.is_open = True
        else:
            self._call_without_device("open")

    def _start(self) -> None:
        if not self.is_plugged:
            self._call_without_device("start", self._subscriber)
            self.is_started = self.is_open
            if self.is_started:
                self._bench.wait_for_loss(self._transport)
            return
        self._transport.start(self._subscriber)
        self.is_open = self.is_started = True
        if self.is_in_doubt:
            self._wait_for_return()
        # Checked now, the result of a start shows in far more histories.
        self._data()

    def _call_without_device(self, name: str, *arguments: object) -> None:
        """Make a call that must fail if nothing was open, and may fail otherwise."""
        must_fail = not self.is_open and self.can.can_be_absent
        has_failed = self._transport.refusal(name, *arguments) is not None
        self._bench.require(has_failed or not must_fail, f"{name}() succeeded without a device")
        may_fail = not self.is_started
        self._bench.require(may_fail or not has_failed, f"{name}() failed while it was started")
        self.is_open = not has_failed

    def _stop(self) -> None:
        self._transport.stop()
        self.is_started = False

    def _close(self) -> None:
        self._transport.close()
        self.is_open = self.is_started = self.is_in_doubt = False

    def _data(self) -> None:
        if not self.is_started:
            self._peer.send(self._next())
            return
        if self.is_spoiled:
            self._peer.send(*[self._next() for _ in range(self.can.frames_lost_after_junk)])
        payload = self._next()
        self._peer.send(payload)
        arrived = self._bench.frame_arrives(self._subscriber, payload)
        self._bench.require(arrived, f"{payload!r} did not arrive")
        if not self.is_spoiled:
            self._bench.require_frames(self._subscriber, [payload])
        self.is_spoiled = False
        self._subscriber.clear()

    def _junk(self) -> None:
        junk = self._bench.author.junk
        data = junk[len(self._history) % len(junk)]
        before = self._transport.health.received_bytes
        self._peer.send_raw(data)
        # A full link would make the peer wait, once nobody reads.
        self._bench.wait_for_bytes(self._transport, before + len(data))
        self.is_spoiled = True

    def _half(self) -> None:
        encoded = self._peer.encode(self._next())
        self._peer.send_raw(encoded[: len(encoded) // 2])
        self.is_spoiled = True

    def _unplug(self) -> None:
        self._peer.unplug()
        self.is_plugged = False
        self.is_in_doubt = self.is_open
        if self.is_started:
            self._bench.wait_for_loss(self._transport)

    def _replug(self) -> None:
        self._peer.replug()
        self.is_plugged = True
        if self.is_started:
            self._wait_for_return()

    def _wait_for_return(self) -> None:
        came = self._bench.wait_for_return(self._peer, self._subscriber)
        strange = [frame for frame in came if frame not in self._bench.probes]
        self._bench.require(self.is_spoiled or not strange, f"{strange!r} came after a loss")
        self.is_in_doubt = self.is_spoiled = False

    def _look(self) -> None:
        """Describe the state as the model knows it."""
        if not self.is_open:
            self._expect(TransportState.CLOSED, is_open=False)
        elif self.is_started and not self.is_plugged:
            self._expect(TransportState.RECONNECTING, is_open=False)
        elif self.is_plugged and not self.is_in_doubt:
            self._expect(TransportState.CONNECTED, is_open=True)
        if not self.is_spoiled:
            self._bench.require_frames(self._subscriber, [])

    def _expect(self, state: TransportState, *, is_open: bool) -> None:
        transport = self._transport
        seen = transport.state
        self._bench.require(seen is state, f"health.state was {seen.name}, not {state.name}")
        self._bench.require(transport.is_open is is_open, f"is_open was {not is_open}")

    def _next(self) -> bytes:
        return self._bench.author.payload(next(self._numbers))
