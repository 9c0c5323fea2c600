"""Checks of threads: allowed callers, and the thread of the callbacks."""

import threading
from collections.abc import Callable
from functools import partial

from rosbase.contracts.backend import Backend
from rosbase.messages import Vector3
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig
from rosbase.testing.promise import Promise

__all__ = ["ThreadChecks"]

_THREADS = 4
_EACH = 50


class ThreadChecks(BackendRig):
    """Checks that one thread runs callbacks and any thread may call."""

    def test_calls_come_from_any_thread(self) -> None:
        promised, backend = promise("calls-come-from-any-thread"), self.open()
        got: list[tuple[int, int]] = []

        def take(number: int) -> None:
            got.append((number, threading.get_ident()))

        self._on_several_threads(
            promised, lambda number: backend.call_soon(partial(take, number)), "call_soon"
        )
        promised.require(not got, f"{len(got)} functions were called although nobody spun")
        self.wait(
            promised,
            lambda: len(got) >= _THREADS * _EACH,
            lambda: f"{len(got)} of {_THREADS * _EACH} functions were called",
            backend,
        )
        promised.require(
            {ident for _, ident in got} == {threading.get_ident()},
            "a function was called on another thread than that which spins",
        )
        self._require_order(promised, [number for number, _ in got])

    def test_callbacks_run_on_the_spinning_thread(self) -> None:
        promised, backend = promise("callbacks-run-on-the-spinning-thread"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        idents: set[int] = set()

        def note(*_: object) -> None:
            idents.add(threading.get_ident())

        backend.create_subscription(Vector3, self.topic, note, 10)
        timer = backend.create_timer(0.001, note)
        self.on_thread(promised, lambda: talker.say(1), "publish, on another thread,")
        backend.executor.clock.sleep(0.01)
        promised.require(
            not idents and not listener.numbers, "a callback was called although nobody spun"
        )
        self.wait(promised, lambda: idents, lambda: "no callback was called", backend)
        backend.destroy_timer(timer)
        self.settle(promised, talker, listener)
        promised.require(
            idents == {threading.get_ident()},
            "a callback was called on another thread than that which spins",
        )

    def test_callbacks_may_use_the_backend(self) -> None:
        promised, backend = promise("callbacks-may-use-the-backend"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        other, answers = f"{self.topic}_answers", list[float]()
        backend.create_subscription(Vector3, other, lambda answer: answers.append(answer.x), 10)
        answering = backend.create_publisher(Vector3, other, 10)
        self.connect(promised, talker, listener)

        def use(message: Vector3) -> None:
            answering.publish(message)
            publisher = backend.create_publisher(Vector3, other, 10)
            subscription = backend.create_subscription(Vector3, other, print, 10)
            timer = backend.create_timer(60.0, print)
            backend.destroy_publisher(publisher)
            backend.destroy_subscription(subscription)
            backend.destroy_timer(timer)

        backend.create_subscription(Vector3, self.topic, use, 10)
        # On another thread, because a publish that waits for its own thread hangs for ever.
        self.on_thread(
            promised,
            lambda: self.wait(
                promised,
                lambda: answers,
                lambda: "what a callback has published has not arrived",
                backend,
                meanwhile=talker.mark,
            ),
            "spinning, with a callback that publishes,",
        )

    def test_messages_wake_the_spinner(self) -> None:
        promised, backend = promise("messages-wake-the-spinner"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        self._require_woken(promised, backend, lambda: talker.say(1), lambda: listener.numbers)

    def test_timers_wake_the_spinner(self) -> None:
        promised, backend = promise("timers-wake-the-spinner"), self.open()
        calls: list[int] = []
        self._require_woken(
            promised,
            backend,
            lambda: backend.create_timer(0.001, lambda: calls.append(1)),
            lambda: calls,
        )

    def test_errors_reach_the_spinner(self) -> None:
        promised, backend = promise("errors-reach-the-spinner"), self.open()
        talker, raised = self.talker(backend), list[str]()

        def fail(what: str, *_: object) -> None:
            raise ArithmeticError(what)

        listener = self.listener(backend)
        self.connect(promised, talker, listener)
        backend.create_subscription(Vector3, self.topic, partial(fail, "subscription"), 10)
        backend.create_timer(0.01, partial(fail, "timer"))
        backend.call_soon(partial(fail, "call"))

        def spin() -> None:
            try:
                talker.mark()
                backend.spin_once(0.001)
            except ArithmeticError as error:
                raised.append(str(error))

        self.wait(
            promised,
            lambda: {"subscription", "timer", "call"} <= set(raised),
            lambda: f"of a subscription, a timer and a call that raise, {set(raised)} did",
            meanwhile=spin,
        )
        talker.say(1, 2, 3)
        self.wait(
            promised,
            lambda: listener.numbers == [1, 2, 3],
            lambda: f"beside callbacks that raise, {listener.numbers} arrived of [1, 2, 3]",
            meanwhile=spin,
        )

    def test_publishing_is_for_any_thread(self) -> None:
        promised, backend = promise("publishing-is-for-any-thread"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        self._on_several_threads(promised, talker.say, "publish")
        self.settle(promised, talker, listener)
        heard = len(listener.numbers)
        promised.require(
            sorted(listener.numbers) == list(range(_THREADS * _EACH)),
            f"{heard} of {_THREADS * _EACH} messages from {_THREADS} threads arrived",
        )
        self._require_order(promised, listener.numbers)

    def test_publishing_waits_for_nobody(self) -> None:
        promised, backend = promise("publishing-waits-for-nobody"), self.open()
        talker, listener = self.talker(backend, 1), self.listener(backend, 1)
        self.connect(promised, talker, listener)
        self.on_thread(promised, lambda: talker.say(*range(_EACH)), f"publish, {_EACH} times,")

    def test_destroying_is_for_any_thread(self) -> None:
        promised, backend = promise("destroying-is-for-any-thread"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        calls: list[int] = []
        timer = backend.create_timer(0.001, lambda: calls.append(1))

        def destroy() -> None:
            backend.destroy_timer(timer)
            backend.destroy_subscription(listener.subscription)
            backend.destroy_publisher(talker.publisher)

        self.connect(promised, talker, listener)
        self.on_thread(promised, destroy, "destroying, on another thread,")
        calls.clear()
        listener.heard.clear()
        other, witness = self.talker(backend), self.listener(backend)
        self.connect(promised, other, witness)
        promised.require(
            not calls and not listener.heard, "what another thread had destroyed was called back"
        )

    def _on_several_threads(
        self, promised: Promise, call: Callable[[int], object], doing: str
    ) -> None:
        """Call it on several threads at once, each with its own numbers."""
        together = threading.Barrier(_THREADS)

        def work(first: int) -> None:
            together.wait(self.patience_s)
            for number in range(first, first + _EACH):
                call(number)

        firsts = range(0, _THREADS * _EACH, _EACH)
        self.on_threads(promised, [partial(work, first) for first in firsts], doing)

    def _require_order(self, promised: Promise, numbers: list[int]) -> None:
        for first in range(0, _THREADS * _EACH, _EACH):
            own = [number for number in numbers if first <= number < first + _EACH]
            promised.require(own == sorted(own), "what one thread sent came in another order")

    def _require_woken(
        self,
        promised: Promise,
        backend: Backend,
        disturb: Callable[[], object],
        came: Callable[[], object],
    ) -> None:
        """Disturb a sleeping spinner from another thread; it must react at once."""
        asleep, clock = threading.Event(), backend.executor.clock

        def disturb_later() -> None:
            asleep.wait(self.patience_s)
            # The spinner takes a moment to fall asleep; a faster thread finds less.
            clock.sleep(0.02)
            disturb()

        thread = threading.Thread(target=disturb_later, daemon=True)
        thread.start()
        backend.call_soon(asleep.set)
        start_ns, deadline_ns = clock.monotonic_ns(), self.deadline_ns()
        while not came() and clock.monotonic_ns() < deadline_ns:
            backend.spin_once(self.patience_s)
        took_s = (clock.monotonic_ns() - start_ns) / 1e9
        thread.join(self.patience_s)
        promised.require(
            came() and took_s < 0.8 * self.patience_s,
            f"a spinner that was to wait {self.patience_s:g} s woke up after {took_s:.1f} s",
        )
