"""Checks of objects that end: destroyed, or closed with their backend."""

import threading
from typing import Any

from rosbase.contracts.backend import Backend
from rosbase.errors import BackendError
from rosbase.messages import Imu, String
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig, Listener
from rosbase.testing.promise import Promise
from rosbase.testing.resources import descriptors

__all__ = ["EndingChecks"]

_WORDS = range(20)
_LIVES = 3
_VARYING = ("header.stamp", "orientation", "angular_velocity", "linear_acceleration")
_SAMPLE: Any = (0, (0.0, 0.0, 0.0, 1.0), (0.0,) * 3, (0.0,) * 3)


class EndingChecks(BackendRig):
    """Checks of destroy and close: no more callbacks, no loss, no leaks."""

    def test_destroyed_subscriptions_are_silent(self) -> None:
        promised, backend = promise("destroyed-subscriptions-are-silent"), self.open()
        talker, first = self.talker(backend), self.listener(backend)
        later = self.listener(backend)
        self.connect(promised, talker, first, later)
        # Its messages wait when another callback destroys it, ahead of its own first one.
        later.heard.clear()
        backend.call_soon(lambda: backend.destroy_subscription(later.subscription))
        talker.say(1, 2, 3)
        self.settle(promised, talker, first)
        promised.require(not later.heard, f"destroyed, it heard {later.heard}")

    def test_ended_publishers_are_silent(self) -> None:
        promised, backend = promise("ended-publishers-are-silent"), self.open()
        ended, other, listener = self.talker(backend), self.talker(backend), self.listener(backend)
        samples = backend.create_publisher(Imu, f"{self.topic}_imu", 1)
        send = backend.prepared_sender(samples, Imu(), _VARYING)
        more_samples = backend.create_publisher(Imu, f"{self.topic}_imu", 1)
        send_more = backend.prepared_sender(more_samples, Imu(), _VARYING)
        self.connect(promised, ended, listener)
        self.connect(promised, other, listener)
        backend.destroy_publisher(ended.publisher)
        backend.destroy_publisher(samples)
        self.raises_nothing(promised, lambda: ended.say(1), "publish, after it was destroyed,")
        self.raises_nothing(promised, lambda: send(*_SAMPLE), "a sender of samples, likewise,")
        self.settle(promised, other, listener)
        promised.require(not listener.numbers, "what a destroyed publisher sent has arrived")
        backend.close()
        self.raises_nothing(promised, lambda: other.say(1), "publish, after close,")
        self.raises_nothing(promised, lambda: send_more(*_SAMPLE), "a sender, after close,")

    def test_destroying_twice_is_harmless(self) -> None:
        promised, backend = promise("destroying-twice-is-harmless"), self.open()

        def destroy(publisher: Any, subscription: Any, timer: Any) -> None:
            backend.destroy_publisher(publisher)
            backend.destroy_subscription(subscription)
            backend.destroy_timer(timer)

        destroyed, left = _create(backend, self.topic), _create(backend, self.topic)
        destroy(*destroyed)
        self.raises_nothing(promised, lambda: destroy(*destroyed), "destroying again")
        backend.close()
        self.raises_nothing(promised, lambda: destroy(*left), "destroying, after close,")

    def test_last_words_arrive(self) -> None:
        promised, backend = promise("last-words-arrive"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        talker.say(*_WORDS)
        backend.destroy_publisher(talker.publisher)
        self._require_words(promised, listener)

    def test_last_words_outlive_the_backend(self) -> None:
        self.needs("several_per_process")
        promised, backend = promise("last-words-outlive-the-backend"), self.open()
        talker, listener = self.talker(backend), self.listener(self.open_peer())
        self.connect(promised, talker, listener)
        talker.say(*_WORDS)
        backend.close()
        self._require_words(promised, listener)

    def test_closing_twice_is_harmless(self) -> None:
        promised, backend = promise("closing-twice-is-harmless"), self.open()
        backend.close()
        self.raises_nothing(promised, backend.close, "close, again,")

    def test_closing_is_bounded(self) -> None:
        promised, backend = promise("closing-is-bounded"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        talker.say(*_WORDS)
        self.on_thread(promised, backend.close, "close")

    def test_closing_ends_threads(self) -> None:
        promised, before = promise("closing-ends-threads"), set(threading.enumerate())
        backend = self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        backend.close()

        def left() -> list[str]:
            return [thread.name for thread in set(threading.enumerate()) - before]

        self.wait(promised, lambda: not left(), lambda: f"after close these run on: {left()}")

    def test_closing_gives_descriptors_back(self) -> None:
        promised = promise("closing-gives-descriptors-back")

        def live() -> None:
            backend = self.open()
            talker, listener = self.talker(backend), self.listener(backend)
            self.connect(promised, talker, listener)
            backend.close()

        # A descriptor opened once for the whole process belongs to no backend.
        live()
        before = descriptors()
        for _ in range(_LIVES):
            live()
        self.wait(
            promised,
            lambda: descriptors() <= before,
            lambda: f"{descriptors()} were open after {_LIVES} more backends, {before} before",
        )

    def test_closed_backends_call_nobody(self) -> None:
        promised, backend = promise("closed-backends-call-nobody"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        called: list[str] = []
        self.connect(promised, talker, listener)
        timer = backend.create_timer(0.001, lambda: called.append("timer"))
        talker.say(1)
        self.wait(promised, lambda: backend.executor.ready, lambda: "the message has not arrived")
        backend.call_soon(lambda: called.append("call"))
        backend.executor.clock.sleep(0.005)
        backend.close()
        timer.reset()
        for _ in range(5):
            backend.spin_once(0.005)
        promised.require(not listener.numbers, "a subscription was called back after close")
        promised.require(not called, f"a {' and a '.join(called)} was called back after close")

    def test_closed_backends_refuse(self) -> None:
        promised, backend = promise("closed-backends-refuse"), self.open()
        backend.close()
        for what, create in {
            "a publisher": lambda: self.talker(backend),
            "a subscription": lambda: self.listener(backend),
            "a timer": lambda: backend.create_timer(1.0, print),
        }.items():
            self.refuses(promised, BackendError, create, f"{what}, after close,")

    def test_closing_leaves_others_alone(self) -> None:
        self.needs("several_per_process")
        promised, backend, peer = (
            promise("closing-leaves-others-alone"),
            self.open(),
            self.open_peer(),
        )
        talker, listener = self.talker(peer), self.listener(peer)
        gone = self.listener(backend)
        self.connect(promised, talker, listener, gone)
        backend.close()
        talker.say(*_WORDS)
        self._require_words(promised, listener)

    def _require_words(self, promised: Promise, listener: Listener) -> None:
        self.wait(
            promised,
            lambda: listener.numbers == list(_WORDS),
            lambda: f"of {len(_WORDS)} messages {len(listener.numbers)} arrived",
            listener.backend,
        )


def _create(backend: Backend, topic: str) -> tuple[Any, Any, Any]:
    """Return one of each object that can be destroyed."""
    return (
        backend.create_publisher(String, topic, 1),
        backend.create_subscription(String, topic, print, 1),
        backend.create_timer(1.0, print),
    )
