"""Fixtures for the checks of a backend: backends, talkers, listeners, bounded waits."""

import os
import threading
from collections.abc import Callable, Iterable
from itertools import count
from operator import attrgetter
from typing import Any

import pytest
from attrs import frozen

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.messages import Vector3
from rosbase.parameters import ParameterValue
from rosbase.qos import QoSProfile
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.seen import raised

__all__ = ["BackendCapabilities", "BackendRig", "Listener", "ServiceKind", "Talker"]

_CLOCK = SystemClock()
_NS_PER_S = 1_000_000_000
_MOMENT_NS = 5_000_000
_POLL_S = 0.001
_topics = count(1)
_marks = count(1)


@frozen
class BackendCapabilities:
    """Optional capabilities of a backend. Checks of undeclared ones are skipped, and say so."""

    delivers_in_process: bool = False
    """Messages reach this process's own subscriptions without leaving the process."""
    several_per_process: bool = False
    """More than one backend can be open in a process, and they hear each other."""
    takes_a_clock: bool = False
    """It uses `BackendOptions.clock`, so that tests can run in virtual time."""
    has_log_handler: bool = False
    """It receives the log of its manager or standalone node."""
    has_services: bool = False
    """It has services and clients."""
    has_taps: bool = False
    """It has taps, a graph, and formats of messages."""


class Number:
    """A type of services that answers a number with a number."""

    @frozen
    class Request:
        """Request of a number."""

        number: int = 0

    @frozen
    class Response:
        """Answer."""

        number: int = 0


@frozen
class ServiceKind:
    """A type of services for the checks: requests and answers that carry a number up to 1000."""

    srv_type: Any = Number
    """The type."""
    request: Callable[[int], Any] = Number.Request
    """Makes a request of a number."""
    response: Callable[[int], Any] = Number.Response
    """Makes an answer of a number."""
    number: Callable[[Any], int] = attrgetter("number")
    """Returns the number of a request or an answer."""


class Talker:
    """Publisher of numbers."""

    def __init__(self, backend: Backend, topic: str, profile: int | QoSProfile) -> None:
        self.publisher = backend.create_publisher(Vector3, topic, profile)

    def say(self, *numbers: int) -> None:
        """Publish a message for each number."""
        for number in numbers:
            self.publisher.publish(Vector3(x=float(number)))

    def mark(self) -> int:
        """Publish a number that is not counted, and return it."""
        mark = -next(_marks)
        self.say(mark)
        return mark


class Listener:
    """Subscription to numbers."""

    def __init__(self, backend: Backend, topic: str, profile: int | QoSProfile) -> None:
        self.backend = backend
        self.heard: list[int] = []
        """All received numbers, marks included."""
        self.subscription = backend.create_subscription(Vector3, topic, self._hear, profile)

    @property
    def numbers(self) -> list[int]:
        """Received numbers, without marks."""
        return [number for number in self.heard if number >= 0]

    def _hear(self, message: Any) -> None:
        # A message of another class should not have come; it counts as 0.
        self.heard.append(int(getattr(message, "x", 0)))


class BackendRig:
    """Base class that opens the backends of a check, and closes them after it."""

    capabilities = BackendCapabilities()
    """Declared capabilities of the backend."""
    service_kind = ServiceKind()
    """Type of the services. Set another one if the backend cannot send classes of Python."""
    patience_s = 5.0
    """Timeout for events that should come at once, in seconds."""

    def make_backend(self, options: BackendOptions) -> Backend:
        """Make a backend with these options. Called for each backend that a check needs."""
        raise promise("opens").broken(f"{type(self).__name__} has no make_backend(self, options)")

    def make_peer(self, options: BackendOptions) -> Backend:
        """Make another backend of the same world. Override it if it needs different code."""
        return self.make_backend(options)

    # For pytest, and for code that calls a single check.

    def setup_method(self) -> None:
        """Set up; pytest calls it before each check."""
        self.opened: list[Backend] = []
        # Other programs in the same world do not hear it.
        self.topic = f"kit_{os.getpid()}_{next(_topics)}"

    def teardown_method(self) -> None:
        """Close all that the check has opened; pytest calls it after each check."""
        for backend in self.opened:
            self.on_thread(promise("closing-is-bounded"), backend.close, "close")

    # For the checks.

    def needs(self, capability: str) -> None:
        """Skip the check unless the backend declares the capability."""
        if not getattr(self.capabilities, capability):
            pytest.skip(f"BackendCapabilities({capability}=True) is not declared")

    def open(
        self, clock: Clock = _CLOCK, parameters: "dict[str, ParameterValue] | None" = None
    ) -> Backend:
        """Open the backend to be checked, under the name `kit`."""
        return self._open(self.make_backend, BackendOptions("kit", parameters or {}, clock))

    def open_peer(self) -> Backend:
        """Open another backend, under the name `peer`."""
        return self._open(self.make_peer, BackendOptions("peer"))

    def talker(self, backend: Backend, profile: int | QoSProfile = 1000) -> Talker:
        """Create a publisher on the topic of this check."""
        return Talker(backend, self.topic, profile)

    def listener(self, backend: Backend, profile: int | QoSProfile = 1000) -> Listener:
        """Create a subscription to the topic of this check."""
        return Listener(backend, self.topic, profile)

    def wait(
        self,
        promised: Promise,
        holds: Callable[[], object],
        seen: Callable[[], str],
        *spun: Backend,
        meanwhile: Callable[[], object] = lambda: _CLOCK.sleep(_POLL_S),
    ) -> None:
        """Spin the backends until a condition holds; break the promise at the timeout."""
        deadline_ns = self.deadline_ns()
        while not holds():
            if _CLOCK.monotonic_ns() > deadline_ns:
                raise promised.broken(f"{seen()}, after {self.patience_s:g} s")
            meanwhile()
            for backend in spun:
                now_ns = backend.executor.clock.monotonic_ns()
                backend.spin_until(now_ns + _MOMENT_NS, holds)

    def connect(self, promised: Promise, talker: Talker, *listeners: Listener) -> None:
        """Wait until all listeners hear the talker, and no message is in transit."""
        self.wait(
            promised,
            lambda: all(listener.heard for listener in listeners),
            lambda: "a subscription does not hear a publisher of its topic",
            *(listener.backend for listener in listeners),
            meanwhile=talker.mark,
        )
        self.settle(promised, talker, *listeners)

    def settle(self, promised: Promise, talker: Talker, *listeners: Listener) -> None:
        """Wait until the listeners have received all messages of the talker."""
        mark = talker.mark()
        self.wait(
            promised,
            lambda: all(mark in listener.heard for listener in listeners),
            lambda: "the last of several messages has not arrived",
            *(listener.backend for listener in listeners),
        )

    def raises_nothing(self, promised: Promise, function: Callable[[], object], doing: str) -> None:
        """Call it; an exception breaks the promise."""
        try:
            function()
        except Exception as error:
            raise promised.broken(raised(doing, error)) from error

    def refuses(
        self,
        promised: Promise,
        kind: type[Exception],
        function: Callable[[], object],
        doing: str,
        shown: str = "",
    ) -> None:
        """Call it; the promise is broken unless it raises that error, in one line that shows it."""
        try:
            function()
        except kind as error:
            text = str(error)
            promised.require("\n" not in text, f"{doing} raised several lines: {text!r}")
            promised.require(shown in text, f"{doing} raised {text!r}, without {shown!r}")
        except Exception as error:
            raise promised.broken(raised(doing, error)) from error
        else:
            raise promised.broken(f"{doing} raised no {kind.__name__}")

    def on_thread(self, promised: Promise, function: Callable[[], object], doing: str) -> None:
        """Call it on another thread; it must return soon and raise nothing."""
        self.on_threads(promised, [function], doing)

    def on_threads(
        self, promised: Promise, functions: Iterable[Callable[[], object]], doing: str
    ) -> None:
        """Call each of them on its own thread, all at once; likewise."""
        errors: list[BaseException] = []

        def run(function: Callable[[], object]) -> None:
            try:
                function()
            except BaseException as error:
                errors.append(error)

        threads = [
            threading.Thread(target=run, args=(function,), name="kit", daemon=True)
            for function in functions
        ]
        for thread in threads:
            thread.start()
        self._join(promised, threads, doing)
        promised.require(not errors, "; ".join(raised(doing, error) for error in errors))

    def deadline_ns(self) -> int:
        """Return the end of the timeout, on the monotonic clock of the machine."""
        return _CLOCK.monotonic_ns() + int(self.patience_s * _NS_PER_S)

    def _join(self, promised: Promise, threads: list[threading.Thread], doing: str) -> None:
        deadline_ns = self.deadline_ns()
        for thread in threads:
            thread.join(max(0.0, (deadline_ns - _CLOCK.monotonic_ns()) / _NS_PER_S))
        promised.require(
            not any(thread.is_alive() for thread in threads),
            f"{doing} has not returned after {self.patience_s:g} s",
        )

    def _open(self, make: Callable[[BackendOptions], Backend], options: BackendOptions) -> Backend:
        try:
            backend = make(options)
        except BrokenPromiseError:
            raise
        except Exception as error:
            raise promise("opens").broken(raised(make.__name__, error)) from error
        promise("opens").require(
            isinstance(backend, Backend), f"{make.__name__} gave {type(backend).__name__}"
        )
        self.opened.append(backend)
        return backend
