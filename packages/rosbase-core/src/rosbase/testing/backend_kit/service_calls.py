"""Checks of calls: their names, types and answers, and what may run while they wait."""

import threading
from functools import partial
from typing import Any

from rosbase.clock import SystemClock
from rosbase.contracts.backend import Backend
from rosbase.contracts.service_client import MOST_CALLS_DEEP
from rosbase.errors import BackendError, ServiceDepthError, ServiceError
from rosbase.testing.backend_kit.service_rig import ServiceRig, take_over
from rosbase.testing.promise import Promise

__all__ = ["ServiceCallChecks"]

_MANY = 200
_THREADS = 4
_CLOCK = SystemClock()
_NO_NAMES: tuple[Any, ...] = ("", "a//b", "1a", "a b", "a-b", 5, "a/~")


class ServiceCallChecks(ServiceRig):
    """Checks that calls are answered wherever they come from, and let nothing else run."""

    def test_services_answer(self) -> None:
        promised, backend = self.begin("services-answer")
        served = self.serve(backend, self.topic)
        clients = [self.client(backend, name) for name in (self.topic, f"/{self.topic}")]

        def work() -> None:
            for number in range(_MANY):
                answer = self.ask(clients[number % 2], number)
                promised.require(
                    answer == number + 1, f"the answer to {number} was {answer}, not {number + 1}"
                )

        self.calling(promised, backend, work)
        promised.require(
            served == list(range(_MANY)), f"of {_MANY} requests, {len(served)} were answered"
        )

    def test_service_names_are_full(self) -> None:
        promised, backend = self.begin("service-names-are-full")
        space, _, name = f"/{backend.node_name}".rpartition("/")
        kind = self.service_kind.srv_type
        for given, full in {
            self.topic: f"{space}/{self.topic}",
            f"/a/{self.topic}": f"/a/{self.topic}",
            f"~/{self.topic}": f"{space}/{name}/{self.topic}",
        }.items():
            for end in (
                backend.create_service(kind, given, self.answer),
                backend.create_client(kind, given),
            ):
                shown = end.service_name
                promised.require(shown == full, f"{given!r} is shown as {shown!r}")

    def test_wrong_service_names_are_errors(self) -> None:
        promised, backend = self.begin("wrong-service-names-are-errors")
        for name in _NO_NAMES:
            self._refuses_service(promised, backend, self.service_kind.srv_type, name, repr(name))

    def test_wrong_service_types_are_errors(self) -> None:
        promised, backend = self.begin("wrong-service-types-are-errors")
        for kind in (int, None, "Trigger"):
            self._refuses_service(promised, backend, kind, self.topic, self.topic)

    def test_wrong_requests_are_errors(self) -> None:
        promised, backend = self.begin("wrong-requests-are-errors")
        served, client = self.serve(backend, self.topic), self.client(backend, self.topic)
        for wrong in ("words", None, self.service_kind.response(1)):
            for what, call in (("call", client.call), ("call_async", client.call_async)):
                self.refuses(
                    promised,
                    TypeError,
                    partial(call, wrong),
                    f"{what} with {wrong!r}",
                    self.topic,
                )
        self.calling(promised, backend, lambda: self.ask(client, 1))
        promised.require(served == [1], f"of the number 1 and wrong requests, {served} came")

    def test_any_thread_may_call(self) -> None:
        promised, backend = self.begin("any-thread-may-call")
        self.serve(backend, self.topic)
        client = self.client(backend, self.topic)
        answers: list[tuple[int, int]] = []

        def work(first: int) -> None:
            for number in range(first, first + _MANY // _THREADS):
                answers.append((number, self.ask(client, number)))

        threads = [
            threading.Thread(target=self.keeping(partial(work, number * _MANY)), daemon=True)
            for number in range(_THREADS)
        ]
        take_over(backend)
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
        promised, backend = self.begin("callbacks-of-services-run-on-the-spinning-thread")
        idents: list[int] = []

        def answer(request: Any, response: Any) -> Any:
            idents.append(threading.get_ident())
            return self.answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        future = self.client(backend, self.topic).call_async(self.service_kind.request(1))
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
        promised, backend = self.begin("waiting-calls-let-services-run")
        other = f"{self.topic}_other"
        inner = self.client(backend, other)
        self.serve(backend, other)

        def answer(request: Any) -> Any:
            return self.service_kind.response(self.ask(inner, self.ask(inner, 0)))

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        client, answers = self.client(backend, self.topic), list[int]()
        self.calling(promised, backend, lambda: answers.append(self.ask(client, 0)))
        promised.require(answers == [2], f"two calls of another service gave {answers}, not [2]")

    def test_waiting_calls_let_nothing_else_run(self) -> None:
        promised, backend = self.begin("waiting-calls-let-nothing-else-run")
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        ran: list[str] = []
        self.serve(backend, f"{self.topic}_there")
        there = self.client(backend, f"{self.topic}_there")
        absent = self.client(backend, f"{self.topic}_absent")

        def work() -> None:
            backend.create_timer(0.001, lambda: ran.append("timer"))
            backend.call_soon(lambda: ran.append("call"))
            talker.say(1)
            self.ask(there, 1)
            self.fails(promised, lambda: self.ask(absent, 1, self.patience_s / 5))

        self.calling(promised, backend, work)
        ran += ["message"] if listener.numbers else []
        promised.require(not ran, f"while a call waited, a {' and a '.join(ran)} ran")

    def test_two_may_call_each_other(self) -> None:
        self.needs("several_per_process")
        promised, backend = self.begin("two-may-call-each-other")
        pair = (backend, self.open_peer())
        names = [f"{self.topic}_{number}" for number in range(2)]
        clients = [
            self.client(one, other) for one, other in zip(pair, reversed(names), strict=True)
        ]
        for one, name in zip(pair, names, strict=True):
            self.serve(one, name)
        together, answers = threading.Barrier(2), list[int]()

        def work(number: int) -> None:
            take_over(pair[number])
            together.wait(self.patience_s)
            answers.append(self.ask(clients[number], 1, self.patience_s / 2))
            # The other one may still wait for this one's answer.
            deadline_ns = self.deadline_ns()
            while len(answers) < 2 and _CLOCK.monotonic_ns() < deadline_ns:
                pair[number].spin_once(0.01)

        self.on_threads(promised, [partial(work, 0), partial(work, 1)], "a call of each other")
        promised.require(answers == [2, 2], f"two that called each other got {answers}")

    def test_calls_are_limited_in_depth(self) -> None:
        promised, backend = self.begin("calls-are-limited-in-depth")
        client, errors = self.client(backend, self.topic), list[ServiceError]()
        depths: list[int] = []

        def answer(request: Any) -> Any:
            depths.append(len(depths))
            try:
                # A backend without a limit should not take Python's.
                if len(depths) <= 2 * MOST_CALLS_DEEP:
                    return self.service_kind.response(self.ask(client, 1))
            except ServiceError as error:
                errors.append(error)
            return self.answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)
        self.calling(promised, backend, lambda: self.ask(client, 1))
        promised.require(
            len(depths) == MOST_CALLS_DEEP and [type(e) for e in errors] == [ServiceDepthError],
            f"a service that calls itself got {len(depths)} deep, and {errors}",
        )

    def test_calls_wait_for_their_service(self) -> None:
        promised, backend = self.begin("calls-wait-for-their-service")
        client = self.client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1), timeout_s=2 * self.patience_s)
        backend.spin_once(0.01)
        promised.require(not future.done(), "a call has ended before its service has come")
        self.serve(backend, self.topic)
        self.wait(promised, future.done, lambda: "the answer has not come", backend)
        found = future.exception()
        promised.require(found is None, f"a call before its service came is {found!r}")
        self.calling(
            promised,
            backend,
            lambda: promised.require(client.wait_for_service(), "the service is not ready"),
        )

    def _refuses_service(
        self, promised: Promise, backend: Backend, kind: Any, name: Any, shown: str
    ) -> None:
        for what, create in {
            "a service": lambda: backend.create_service(kind, name, self.answer),
            "a client": lambda: backend.create_client(kind, name),
        }.items():
            self.refuses(
                promised, BackendError, create, f"{what} of {kind!r} called {name!r}", shown
            )
