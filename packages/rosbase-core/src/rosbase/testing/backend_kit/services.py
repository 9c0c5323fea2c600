"""Checks of services: calls and answers, and the errors of calls without one."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase.clock import SystemClock
from rosbase.contracts.backend import Backend
from rosbase.contracts.service_client import MOST_CALLS_DEEP
from rosbase.contracts.services import Client
from rosbase.errors import (
    BackendError,
    ServiceDepthError,
    ServiceError,
    ServiceStoppedError,
    ServiceTimeoutError,
)
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig
from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.seen import raised

__all__ = ["ServiceChecks"]

_MANY = 200
_THREADS = 4
# A number that a service answers late.
_SLOW = 7
_CLOCK = SystemClock()
_NO_NAMES: tuple[Any, ...] = ("", "a//b", "1a", "a b", "a-b", 5, "a/~")


class ServiceChecks(BackendRig):
    """Checks that every call ends, with its answer or with an error in time."""

    def test_services_answer(self) -> None:
        promised, backend = self._promised("services-answer")
        served = self._serve(backend, self.topic)
        clients = [self._client(backend, name) for name in (self.topic, f"/{self.topic}")]

        def work() -> None:
            for number in range(_MANY):
                answer = self._ask(clients[number % 2], number)
                promised.require(
                    answer == number + 1, f"the answer to {number} was {answer}, not {number + 1}"
                )

        self._calling(promised, backend, work)
        promised.require(
            served == list(range(_MANY)), f"of {_MANY} requests, {len(served)} were answered"
        )

    def test_service_names_are_full(self) -> None:
        promised, backend = self._promised("service-names-are-full")
        space, _, name = f"/{backend.node_name}".rpartition("/")
        kind = self.service_kind.srv_type
        for given, full in {
            self.topic: f"{space}/{self.topic}",
            f"/a/{self.topic}": f"/a/{self.topic}",
            f"~/{self.topic}": f"{space}/{name}/{self.topic}",
        }.items():
            for end in (
                backend.create_service(kind, given, self._answer),
                backend.create_client(kind, given),
            ):
                shown = end.service_name
                promised.require(shown == full, f"that of {given!r} is {shown!r}")

    def test_wrong_service_names_are_errors(self) -> None:
        promised, backend = self._promised("wrong-service-names-are-errors")
        for name in _NO_NAMES:
            self._refuses_service(promised, backend, self.service_kind.srv_type, name, repr(name))

    def test_wrong_service_types_are_errors(self) -> None:
        promised, backend = self._promised("wrong-service-types-are-errors")
        for kind in (int, None, "Trigger"):
            self._refuses_service(promised, backend, kind, self.topic, self.topic)

    def test_wrong_requests_are_errors(self) -> None:
        promised, backend = self._promised("wrong-requests-are-errors")
        served, client = self._serve(backend, self.topic), self._client(backend, self.topic)
        for wrong in ("words", None, self.service_kind.response(1)):
            for what, call in (("call", client.call), ("call_async", client.call_async)):
                self.refuses(
                    promised,
                    TypeError,
                    partial(call, wrong),
                    f"{what} with {wrong!r}",
                    self.topic,
                )
        self._calling(promised, backend, lambda: self._ask(client, 1))
        promised.require(served == [1], f"of the number 1 and wrong requests, {served} came")

    def test_any_thread_may_call(self) -> None:
        promised, backend = self._promised("any-thread-may-call")
        self._serve(backend, self.topic)
        client = self._client(backend, self.topic)
        answers: list[tuple[int, int]] = []

        def work(first: int) -> None:
            for number in range(first, first + _MANY // _THREADS):
                answers.append((number, self._ask(client, number)))

        threads = [
            threading.Thread(target=self._keeping(partial(work, number * _MANY)), daemon=True)
            for number in range(_THREADS)
        ]
        _take_over(backend)
        for thread in threads:
            thread.start()
        self.wait(
            promised,
            lambda: not any(thread.is_alive() for thread in threads),
            lambda: f"of {_MANY} calls from {_THREADS} threads, {len(answers)} were answered",
            backend,
        )
        promised.require(
            len(answers) == _MANY and all(answer == number + 1 for number, answer in answers),
            f"of {_MANY} calls from {_THREADS} threads, {len(answers)} were answered",
        )

    def test_callbacks_of_services_run_on_the_spinning_thread(self) -> None:
        promised, backend = self._promised("callbacks-of-services-run-on-the-spinning-thread")
        idents: list[int] = []

        def answer(request: Any, response: Any) -> Any:
            idents.append(threading.get_ident())
            return self._answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        future = self._client(backend, self.topic).call_async(self.service_kind.request(1))
        future.add_done_callback(lambda _: idents.append(threading.get_ident()))
        _CLOCK.sleep(0.01)
        promised.require(not idents, "a callback was called although nobody spun")
        self.wait(
            promised,
            lambda: len(idents) >= 2,
            lambda: f"of a service and of the future of its answer, {len(idents)} were called",
            backend,
        )
        promised.require(
            set(idents) == {threading.get_ident()},
            "a callback was called on another thread than that which spins",
        )

    def test_waiting_calls_let_services_run(self) -> None:
        promised, backend = self._promised("waiting-calls-let-services-run")
        other = f"{self.topic}_other"
        inner = self._client(backend, other)
        self._serve(backend, other)

        def answer(request: Any) -> Any:
            return self.service_kind.response(self._ask(inner, self._ask(inner, 0)))

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        client, answers = self._client(backend, self.topic), list[int]()
        self._calling(promised, backend, lambda: answers.append(self._ask(client, 0)))
        promised.require(answers == [2], f"two calls of another service gave {answers}, not [2]")

    def test_waiting_calls_let_nothing_else_run(self) -> None:
        promised, backend = self._promised("waiting-calls-let-nothing-else-run")
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        ran: list[str] = []
        self._serve(backend, f"{self.topic}_there")
        there = self._client(backend, f"{self.topic}_there")
        absent = self._client(backend, f"{self.topic}_absent")

        def work() -> None:
            backend.create_timer(0.001, lambda: ran.append("timer"))
            backend.call_soon(lambda: ran.append("call"))
            talker.say(1)
            self._ask(there, 1)
            self._fails(promised, lambda: self._ask(absent, 1, self.patience_s / 5))

        self._calling(promised, backend, work)
        ran += ["message"] if listener.numbers else []
        promised.require(not ran, f"while a call waited, a {' and a '.join(ran)} ran")

    def test_two_may_call_each_other(self) -> None:
        self.needs("several_per_process")
        promised, backend = self._promised("two-may-call-each-other")
        pair = (backend, self.open_peer())
        names = [f"{self.topic}_{number}" for number in range(2)]
        clients = [
            self._client(one, other) for one, other in zip(pair, reversed(names), strict=True)
        ]
        for one, name in zip(pair, names, strict=True):
            self._serve(one, name)
        together, answers = threading.Barrier(2), list[int]()

        def work(number: int) -> None:
            _take_over(pair[number])
            together.wait(self.patience_s)
            answers.append(self._ask(clients[number], 1, self.patience_s / 2))
            # The other one may still wait for this one's answer.
            deadline_ns = self.deadline_ns()
            while len(answers) < 2 and _CLOCK.monotonic_ns() < deadline_ns:
                pair[number].spin_once(0.01)

        self.on_threads(promised, [partial(work, 0), partial(work, 1)], "a call of each other")
        promised.require(answers == [2, 2], f"two that called each other got {answers}")

    def test_calls_are_limited_in_depth(self) -> None:
        promised, backend = self._promised("calls-are-limited-in-depth")
        client, errors = self._client(backend, self.topic), list[ServiceError]()
        depths: list[int] = []

        def answer(request: Any) -> Any:
            depths.append(len(depths))
            try:
                # A backend without a limit should not take Python's.
                if len(depths) <= 2 * MOST_CALLS_DEEP:
                    return self.service_kind.response(self._ask(client, 1))
            except ServiceError as error:
                errors.append(error)
            return self._answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        self._calling(promised, backend, lambda: self._ask(client, 1))
        promised.require(
            len(depths) == MOST_CALLS_DEEP and [type(e) for e in errors] == [ServiceDepthError],
            f"a service that calls itself got {len(depths)} deep, and {errors}",
        )

    def test_absent_services_are_errors(self) -> None:
        promised, backend = self._promised("absent-services-are-errors")
        client, timeout_s = self._client(backend, self.topic), self.patience_s / 5

        def work() -> None:
            error = self._fails(promised, lambda: self._ask(client, 1, timeout_s))
            promised.require(
                isinstance(error, ServiceTimeoutError), f"an absent service is {error!r}"
            )
            promised.require(
                not client.service_is_ready() and not client.wait_for_service(timeout_s=0.01),
                "a service that nobody has created is ready",
            )

        self._calling(promised, backend, work)

    def test_calls_wait_for_their_service(self) -> None:
        promised, backend = self._promised("calls-wait-for-their-service")
        client = self._client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1), timeout_s=2 * self.patience_s)
        backend.spin_once(0.01)
        promised.require(not future.done(), "a call has ended before its service has come")
        self._serve(backend, self.topic)
        self.wait(promised, future.done, lambda: "the answer has not come", backend)
        found = future.exception()
        promised.require(found is None, f"a call before its service came is {found!r}")
        self._calling(
            promised,
            backend,
            lambda: promised.require(client.wait_for_service(), "the service is not ready"),
        )

    def test_late_answers_are_dropped_and_counted(self) -> None:
        promised, backend = self._promised("late-answers-are-dropped-and-counted")
        client = self._client(backend, self.topic)
        backend.create_service(self.service_kind.srv_type, self.topic, self._late)
        self._calling(promised, backend, lambda: self._ask(client, 0))

        def work() -> None:
            error = self._fails(promised, lambda: self._ask(client, _SLOW, self.patience_s / 10))
            promised.require(isinstance(error, ServiceTimeoutError), f"a slow service is {error!r}")

        # Another thread spins, and answers when the caller has given up.
        caller = threading.Thread(target=self._keeping(work), daemon=True)
        _take_over(backend)
        caller.start()
        self.wait(
            promised,
            lambda: client.dropped == 1 and not caller.is_alive(),
            lambda: f"after a call that was too late, dropped is {client.dropped}",
            backend,
        )
        self._require_kept(promised)

    def test_cancelled_calls_stay_so(self) -> None:
        promised, backend = self._promised("cancelled-calls-stay-so")
        self._serve(backend, self.topic)
        client = self._client(backend, self.topic)
        self._calling(promised, backend, lambda: self._ask(client, 0))
        future = client.call_async(self.service_kind.request(1))
        future.cancel()
        backend.spin_once(0.01)
        self._calling(promised, backend, lambda: self._ask(client, 0))
        promised.require(
            future.done() and future.cancelled(), "a cancelled call is not done, or not cancelled"
        )
        self.refuses(promised, ServiceError, future.result, "the result of a cancelled call")

    def test_failing_services_are_errors(self) -> None:
        promised, backend = self._promised("failing-services-are-errors")
        client = self._client(backend, self.topic)

        def answer(request: Any) -> Any:
            number = self.service_kind.number(request)
            if number:
                raise ArithmeticError("it fails")
            return self._answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)

        def work() -> None:
            self._ask(client, 0)
            self._fails(promised, lambda: self._ask(client, 1, self.patience_s / 2))
            promised.require(self._ask(client, 0) == 1, "it answers no more after it has failed")

        self._calling(promised, backend, work)

    def test_services_that_go_away_are_errors(self) -> None:
        promised, backend = self._promised("services-that-go-away-are-errors")
        client = self._client(backend, self.topic)
        service = backend.create_service(self.service_kind.srv_type, self.topic, self._answer)
        self._calling(promised, backend, lambda: self._ask(client, 0))
        future = client.call_async(self.service_kind.request(1), timeout_s=self.patience_s / 5)
        backend.destroy_service(service)
        self.wait(promised, future.done, lambda: "a call of it has not ended", backend)
        self.refuses(
            promised, ServiceError, future.result, "a call of a destroyed service", self.topic
        )
        self.wait(promised, lambda: not client.service_is_ready(), lambda: "it is ready", backend)

    def test_inner_calls_keep_to_the_time_of_outer_ones(self) -> None:
        promised, backend = self._promised("inner-calls-keep-to-the-time-of-outer-ones")
        client = self._client(backend, self.topic)
        absent = self._client(backend, f"{self.topic}_absent")
        clock = backend.executor.clock

        def answer(request: Any) -> Any:
            if self.service_kind.number(request):
                self._fails(promised, lambda: self._ask(absent, 1, self.patience_s))
            return self._answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)

        def work() -> None:
            self._ask(client, 0)
            begin_ns = clock.monotonic_ns()
            try:
                self._ask(client, 1, self.patience_s / 5)
            except ServiceTimeoutError:
                # The answer came at the end of the time, or just after.
                pass
            took_s = (clock.monotonic_ns() - begin_ns) / 1e9
            promised.require(
                took_s < self.patience_s / 2,
                f"a call with {self.patience_s / 5:g} s took {took_s:.2f} s",
            )

        self._calling(promised, backend, work)

    def test_stops_end_calls(self) -> None:
        promised, backend = self._promised("stops-end-calls")
        absent, stops = self._client(backend, self.topic), list[bool]()

        def stop() -> None:
            stops.append(True)
            backend.call_soon(lambda: None)

        def work() -> None:
            backend.executor.begin(stops.__len__)
            timer = threading.Timer(self.patience_s / 20, stop)
            timer.start()
            error = self._fails(promised, lambda: self._ask(absent, 1, 10 * self.patience_s))
            timer.join()
            promised.require(
                isinstance(error, ServiceStoppedError), f"a stop ended a call with {error!r}"
            )

        self._calling(promised, backend, work)

    def test_destroyed_clients_end_their_calls(self) -> None:
        promised, backend = self._promised("destroyed-clients-end-their-calls")
        client = self._client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1))
        for _ in range(2):
            self.raises_nothing(promised, lambda: backend.destroy_client(client), "destroy_client")
        promised.require(future.done(), "a call goes on although its client was destroyed")
        for call in (future.result, lambda: self._ask(client, 1)):
            self.refuses(promised, ServiceError, call, "a call of a destroyed client", self.topic)

    def test_closed_backends_end_services(self) -> None:
        promised, backend = self._promised("closed-backends-end-services")
        served = self._serve(backend, self.topic)
        service = backend.create_service(
            self.service_kind.srv_type, f"{self.topic}_other", self._answer
        )
        client = self._client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1))
        backend.close()
        backend.spin_once(0.01)
        promised.require(future.done() and not served, "a call goes on although it was closed")
        self.refuses(promised, ServiceError, future.result, "a call, after close,")
        self.raises_nothing(promised, lambda: backend.destroy_service(service), "destroying")
        self.raises_nothing(promised, lambda: backend.destroy_client(client), "destroying")
        kind = self.service_kind.srv_type
        for what, create in {
            "a service": lambda: backend.create_service(kind, self.topic, self._answer),
            "a client": lambda: backend.create_client(kind, self.topic),
        }.items():
            self.refuses(promised, BackendError, create, f"{what}, after close,")

    def _promised(self, name: str) -> tuple[Promise, Backend]:
        """Return a promise and a backend, if backends of this kind have services."""
        self.needs("has_services")
        self._kept: list[Exception] = []
        return promise(name), self.open()

    def _serve(self, backend: Backend, name: str) -> list[int]:
        """Create a service that answers the next number; return the numbers that come."""
        served: list[int] = []

        def answer(request: Any) -> Any:
            served.append(self.service_kind.number(request))
            return self._answer(request)

        backend.create_service(self.service_kind.srv_type, name, answer)
        return served

    def _answer(self, request: Any, response: Any = None) -> Any:
        return self.service_kind.response(self.service_kind.number(request) + 1)

    def _late(self, request: Any) -> Any:
        """Answer; take longer over one number than its caller waits."""
        if self.service_kind.number(request) == _SLOW:
            _CLOCK.sleep(self.patience_s / 5)
        return self._answer(request)

    def _client(self, backend: Backend, name: str) -> Client[Any, Any]:
        return backend.create_client(self.service_kind.srv_type, name)

    def _ask(self, client: Client[Any, Any], number: int, timeout_s: float | None = None) -> int:
        """Call with a number; return that of the answer."""
        limit_s = self.patience_s if timeout_s is None else timeout_s
        answer = client.call(self.service_kind.request(number), timeout_s=limit_s)
        return self.service_kind.number(answer)

    def _fails(self, promised: Promise, call: Callable[[], object]) -> ServiceError:
        """Return the error of a call that must fail, with one line."""
        try:
            call()
        except ServiceError as error:
            promised.require("\n" not in str(error), f"the error has several lines: {error}")
            return error
        raise promised.broken("a call that cannot have an answer raised no ServiceError")

    def _calling(self, promised: Promise, backend: Backend, work: Callable[[], object]) -> None:
        """Do it on a thread that spins the backend, which may hang if a promise is broken."""

        def spin_and_work() -> None:
            _take_over(backend)
            work()

        self.on_thread(promised, self._keeping(spin_and_work), "a call")
        self._require_kept(promised)

    def _keeping(self, work: Callable[[], object]) -> Callable[[], object]:
        """Keep the failure of a check for the thread of the test."""

        def keep() -> None:
            try:
                work()
            except Exception as error:
                self._kept.append(error)

        return keep

    def _require_kept(self, promised: Promise) -> None:
        for error in self._kept:
            if isinstance(error, BrokenPromiseError):
                raise error
            raise promised.broken(raised("a call", error)) from error

    def _refuses_service(
        self, promised: Promise, backend: Backend, kind: Any, name: Any, shown: str
    ) -> None:
        for what, create in {
            "a service": lambda: backend.create_service(kind, name, self._answer),
            "a client": lambda: backend.create_client(kind, name),
        }.items():
            self.refuses(
                promised, BackendError, create, f"{what} of {kind!r} called {name!r}", shown
            )


def _take_over(backend: Backend) -> None:
    """Become the thread that spins."""
    backend.spin_until(backend.executor.clock.monotonic_ns(), lambda: False)
