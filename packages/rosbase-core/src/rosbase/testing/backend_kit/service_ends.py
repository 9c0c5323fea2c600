"""Checks of how calls end that get no answer, or no more."""

import threading
from typing import Any

from rosbase.clock import SystemClock
from rosbase.errors import BackendError, ServiceError, ServiceStoppedError, ServiceTimeoutError
from rosbase.testing.backend_kit.service_rig import ServiceRig, take_over

__all__ = ["ServiceEndChecks"]

# A number that a service answers late.
_SLOW = 7
_CLOCK = SystemClock()


class ServiceEndChecks(ServiceRig):
    """Checks that a call without an answer ends with an error, in time."""

    def test_absent_services_are_errors(self) -> None:
        promised, backend = self.begin("absent-services-are-errors")
        client, timeout_s = self.client(backend, self.topic), self.patience_s / 5

        def work() -> None:
            error = self.fails(promised, lambda: self.ask(client, 1, timeout_s))
            promised.require(
                isinstance(error, ServiceTimeoutError), f"an absent service is {error!r}"
            )
            promised.require(
                not client.service_is_ready() and not client.wait_for_service(timeout_s=0.01),
                "a service that nobody has created is ready",
            )

        self.calling(promised, backend, work)

    def test_late_answers_are_dropped_and_counted(self) -> None:
        promised, backend = self.begin("late-answers-are-dropped-and-counted")
        client = self.client(backend, self.topic)
        backend.create_service(self.service_kind.srv_type, self.topic, self._late)
        self.calling(promised, backend, lambda: self.ask(client, 0))

        def work() -> None:
            error = self.fails(promised, lambda: self.ask(client, _SLOW, self.patience_s / 10))
            promised.require(isinstance(error, ServiceTimeoutError), f"a slow service is {error!r}")

        # Another thread spins, and answers when the caller has given up.
        caller = threading.Thread(target=self.keeping(work), daemon=True)
        take_over(backend)
        caller.start()
        self.wait(
            promised,
            lambda: client.dropped == 1 and not caller.is_alive(),
            lambda: f"after a call that was too late, dropped is {client.dropped}",
            backend,
        )
        self.require_kept(promised)
        # The thread that calls answers itself, and can only notice afterwards.
        self.calling(promised, backend, work)
        take_over(backend)
        self.wait(
            promised,
            lambda: client.dropped == 2,
            lambda: (
                f"after a second one, which its own thread answered, dropped is {client.dropped}"
            ),
            backend,
        )

    def test_cancelled_calls_stay_so(self) -> None:
        promised, backend = self.begin("cancelled-calls-stay-so")
        self.serve(backend, self.topic)
        client = self.client(backend, self.topic)
        self.calling(promised, backend, lambda: self.ask(client, 0))
        future = client.call_async(self.service_kind.request(1))
        future.cancel()
        backend.spin_once(0.01)
        self.calling(promised, backend, lambda: self.ask(client, 0))
        promised.require(
            future.done() and future.cancelled(), "a cancelled call is not done, or not cancelled"
        )
        self.refuses(promised, ServiceError, future.result, "the result of a cancelled call")

    def test_failing_services_are_errors(self) -> None:
        promised, backend = self.begin("failing-services-are-errors")
        client = self.client(backend, self.topic)

        def answer(request: Any) -> Any:
            number = self.service_kind.number(request)
            if number:
                raise ArithmeticError("it fails")
            return self.answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)

        def work() -> None:
            self.ask(client, 0)
            self.fails(promised, lambda: self.ask(client, 1, self.patience_s / 2))
            promised.require(self.ask(client, 0) == 1, "it answers no more after it has failed")

        self.calling(promised, backend, work)

    def test_services_that_go_away_are_errors(self) -> None:
        promised, backend = self.begin("services-that-go-away-are-errors")
        client = self.client(backend, self.topic)
        service = backend.create_service(self.service_kind.srv_type, self.topic, self.answer)
        self.calling(promised, backend, lambda: self.ask(client, 0))
        future = client.call_async(self.service_kind.request(1), timeout_s=self.patience_s / 5)
        backend.destroy_service(service)
        self.wait(promised, future.done, lambda: "a call of it has not ended", backend)
        self.refuses(
            promised, ServiceError, future.result, "a call of a destroyed service", self.topic
        )
        self.wait(promised, lambda: not client.service_is_ready(), lambda: "it is ready", backend)

    def test_inner_calls_keep_to_the_time_of_outer_ones(self) -> None:
        promised, backend = self.begin("inner-calls-keep-to-the-time-of-outer-ones")
        client = self.client(backend, self.topic)
        absent = self.client(backend, f"{self.topic}_absent")
        clock = backend.executor.clock

        def answer(request: Any) -> Any:
            if self.service_kind.number(request):
                self.fails(promised, lambda: self.ask(absent, 1, self.patience_s))
            return self.answer(request)

        backend.create_service(self.service_kind.srv_type, self.topic, answer)

        def work() -> None:
            self.ask(client, 0)
            begin_ns = clock.monotonic_ns()
            try:
                self.ask(client, 1, self.patience_s / 5)
            except ServiceTimeoutError:
                # The answer came at the end of the time, or just after.
                pass
            took_s = (clock.monotonic_ns() - begin_ns) / 1e9
            promised.require(
                took_s < self.patience_s / 2,
                f"a call with {self.patience_s / 5:g} s took {took_s:.2f} s",
            )

        self.calling(promised, backend, work)

    def test_stops_end_calls(self) -> None:
        promised, backend = self.begin("stops-end-calls")
        absent, stops = self.client(backend, self.topic), list[bool]()

        def stop() -> None:
            stops.append(True)
            backend.call_soon(lambda: None)

        def work() -> None:
            backend.executor.begin(stops.__len__)
            timer = threading.Timer(self.patience_s / 20, stop)
            timer.start()
            error = self.fails(promised, lambda: self.ask(absent, 1, 10 * self.patience_s))
            timer.join()
            promised.require(
                isinstance(error, ServiceStoppedError), f"a stop ended a call with {error!r}"
            )

        self.calling(promised, backend, work)

    def test_destroyed_clients_end_their_calls(self) -> None:
        promised, backend = self.begin("destroyed-clients-end-their-calls")
        client = self.client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1))
        for _ in range(2):
            self.raises_nothing(promised, lambda: backend.destroy_client(client), "destroy_client")
        promised.require(future.done(), "a call goes on although its client was destroyed")
        for call in (future.result, lambda: self.ask(client, 1)):
            self.refuses(promised, ServiceError, call, "a call of a destroyed client", self.topic)
        self.serve(backend, self.topic)
        other = self.client(backend, self.topic)
        self.calling(promised, backend, lambda: self.ask(other, 1))
        backend.destroy_client(other)
        promised.require(not other.service_is_ready(), "a service is ready for a destroyed client")
        self.fails(promised, other.wait_for_service)

    def test_closed_backends_end_services(self) -> None:
        promised, backend = self.begin("closed-backends-end-services")
        served = self.serve(backend, self.topic)
        service = backend.create_service(
            self.service_kind.srv_type, f"{self.topic}_other", self.answer
        )
        client = self.client(backend, self.topic)
        future = client.call_async(self.service_kind.request(1))
        backend.close()
        backend.spin_once(0.01)
        promised.require(future.done() and not served, "a call goes on although it was closed")
        self.refuses(promised, ServiceError, future.result, "a call, after close,")
        self.raises_nothing(promised, lambda: backend.destroy_service(service), "destroying")
        self.raises_nothing(promised, lambda: backend.destroy_client(client), "destroying")
        kind = self.service_kind.srv_type
        for what, create in {
            "a service": lambda: backend.create_service(kind, self.topic, self.answer),
            "a client": lambda: backend.create_client(kind, self.topic),
        }.items():
            self.refuses(promised, BackendError, create, f"{what}, after close,")

    def _late(self, request: Any) -> Any:
        """Answer; take longer over one number than its caller waits."""
        if self.service_kind.number(request) == _SLOW:
            _CLOCK.sleep(self.patience_s / 5)
        return self.answer(request)
