"""What is wrong with services."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase.errors import BackendError, ServiceStoppedError, ServiceTimeoutError
from rosbase.local import LocalBackend
from support.backend_mutants.changed import breaks


class ChangedServices(LocalBackend):
    """The backend of the core, with places at which to change something about services."""

    def create_service(self, srv_type: Any, srv_name: Any, callback: Any) -> Any:
        kind, name = self.kind(srv_type), self.service_name(srv_name)
        service: Any = super().create_service(kind, name, self.answering(callback))
        self.change_service(service)
        return service

    def create_client(self, srv_type: Any, srv_name: Any) -> Any:
        kind, name = self.kind(srv_type), self.client_name(srv_name)
        client: Any = super().create_client(kind, name)
        self.change_client(client)
        return client

    def kind(self, srv_type: Any) -> Any:
        return srv_type

    def service_name(self, name: Any) -> Any:
        return name

    def client_name(self, name: Any) -> Any:
        return name

    def answering(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        return callback

    def change_service(self, service: Any) -> None:
        """Changes a service."""

    def change_client(self, client: Any) -> None:
        """Changes a client."""


class RunsAtOnce:
    """An executor that is none."""

    def call_urgently(self, function: Callable[[], object]) -> None:
        function()


class RunsLater:
    """An executor without anything urgent."""

    def __init__(self, call_soon: Callable[[Callable[[], object]], object]) -> None:
        self.call_urgently = call_soon


@breaks("services-answer")
class AnswersAsBefore(ChangedServices):
    def answering(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        answers: list[Any] = []

        def answer(request: Any) -> Any:
            answers.append(callback(request))
            return answers[0]

        return answer


@breaks("services-answer")
class LosesARequest(ChangedServices):
    def change_service(self, service: Any) -> None:
        take, taken = service.take, list[Any]()

        def take_most(call: Any) -> None:
            taken.append(call)
            if len(taken) != 5:
                take(call)

        registered = self._bus.services._services[service.service_name]
        service.take = take_most
        assert registered.providers


@breaks("services-answer")
class TellsNamesApart(ChangedServices):
    def client_name(self, name: Any) -> Any:
        return f"{name}_2" if name.startswith("/") else name


class Named:
    def __init__(self, name: str) -> None:
        self.service_name = name


@breaks("service-names-are-full")
class RepeatsServiceNames(ChangedServices):
    def create_client(self, srv_type: Any, srv_name: Any) -> Any:
        super().create_client(srv_type, srv_name)
        return Named(srv_name)


@breaks("wrong-service-names-are-errors")
class TakesAnyServiceName(ChangedServices):
    def client_name(self, name: Any) -> Any:
        return "any"


@breaks("wrong-service-names-are-errors")
class HidesTheServiceName(ChangedServices):
    def create_service(self, srv_type: Any, srv_name: Any, callback: Any) -> Any:
        try:
            return super().create_service(srv_type, srv_name, callback)
        except BackendError:
            raise BackendError("that is no name") from None


class Anything:
    Request = object
    Response = object


@breaks("wrong-service-types-are-errors")
class TakesAnyServiceType(ChangedServices):
    def kind(self, srv_type: Any) -> Any:
        return srv_type if hasattr(srv_type, "Request") else Anything


@breaks("wrong-requests-are-errors")
class TakesAnyRequest(ChangedServices):
    def change_client(self, client: Any) -> None:
        client._request_type = object


@breaks("any-thread-may-call")
class AnswersOneThread(ChangedServices):
    def change_client(self, client: Any) -> None:
        call = client.call

        def call_here(request: Any, timeout_s: float) -> Any:
            if not self.executor.is_on_own_thread:
                raise BackendError("only one thread may call")
            return call(request, timeout_s)

        client.call = call_here


@breaks("callbacks-of-services-run-on-the-spinning-thread")
class AnswersWithoutSpinning(ChangedServices):
    def change_service(self, service: Any) -> None:
        service._executor = RunsAtOnce()


@breaks("two-may-call-each-other")
@breaks("waiting-calls-let-services-run")
class AnswersOnlyWhileItSpins(ChangedServices):
    def change_service(self, service: Any) -> None:
        service._executor = RunsLater(self.call_soon)


@breaks("waiting-calls-let-nothing-else-run")
class SpinsWhileItWaits(ChangedServices):
    def change_client(self, client: Any) -> None:
        def call(request: Any, timeout_s: float) -> Any:
            future = client.call_async(request, timeout_s)
            deadline_ns = self.clock.monotonic_ns() + int(2e9 * timeout_s)
            self.spin_until(deadline_ns, future.done)
            return future.result()

        client.call = call


_one_at_a_time = threading.Lock()


@breaks("two-may-call-each-other")
class CallsOneAfterTheOther(ChangedServices):
    def change_client(self, client: Any) -> None:
        call = client.call

        def call_alone(request: Any, timeout_s: float) -> Any:
            with _one_at_a_time:
                return call(request, timeout_s)

        client.call = call_alone


@breaks("calls-are-limited-in-depth")
class HasNoBottom(ChangedServices):
    def change_client(self, client: Any) -> None:
        client._check_wait = lambda timeout_s: None


@breaks("absent-services-are-errors")
class RefusesAbsentServices(ChangedServices):
    def change_client(self, client: Any) -> None:
        call = client.call

        def call_known(request: Any, timeout_s: float) -> Any:
            if not client.service_is_ready():
                raise BackendError(f"{client.service_name} is absent")
            return call(request, timeout_s)

        client.call = call_known


@breaks("absent-services-are-errors")
class SaysThatAllAreReady(ChangedServices):
    def change_client(self, client: Any) -> None:
        client.service_is_ready = lambda: True


@breaks("calls-wait-for-their-service")
class ForgetsEarlyCalls(ChangedServices):
    def change_client(self, client: Any) -> None:
        send = client.send

        def send_now(call: Any) -> None:
            if client.service_is_ready():
                send(call)

        client.send = send_now


@breaks("late-answers-are-dropped-and-counted")
class CountsNoLateAnswers(ChangedServices):
    def change_client(self, client: Any) -> None:
        client.count_late = lambda: None


@breaks("late-answers-are-dropped-and-counted")
class TakesLateAnswersOfItsOwnThread(ChangedServices):
    def change_client(self, client: Any) -> None:
        begin = client._begin

        def begin_without_limit(request: Any) -> Any:
            call = begin(request)
            call.limit = lambda deadline_ns, make_error: None
            return call

        client._begin = begin_without_limit


class CannotCancel:
    def __init__(self, future: Any) -> None:
        self.done, self.result = future.done, future.result
        self.cancel = lambda: None
        self.cancelled = lambda: True


@breaks("cancelled-calls-stay-so")
class AnswersWhatWasCancelled(ChangedServices):
    def change_client(self, client: Any) -> None:
        call_async = client.call_async
        client.call_async = lambda *arguments: CannotCancel(call_async(*arguments))


@breaks("failing-services-are-errors")
class RaisesWhatAServiceRaises(ChangedServices):
    def change_service(self, service: Any) -> None:
        def explain(error: Exception) -> None:
            raise error

        service._explain = explain


@breaks("failing-services-are-errors")
class StopsAfterAFailure(ChangedServices):
    def change_service(self, service: Any) -> None:
        explain = service._explain

        def explain_and_end(error: Exception) -> Any:
            self.destroy_service(service)
            return explain(error)

        service._explain = explain_and_end


@breaks("services-that-go-away-are-errors")
class LeavesCallsAlone(ChangedServices):
    def change_service(self, service: Any) -> None:
        service.close = lambda: None

    def change_client(self, client: Any) -> None:
        call_async = client.call_async
        client.call_async = lambda request, timeout_s=0.0: call_async(request, float("inf"))


@breaks("services-that-go-away-are-errors")
class IsReadyForEver(ChangedServices):
    def change_client(self, client: Any) -> None:
        client.service_is_ready = lambda: True


@breaks("inner-calls-keep-to-the-time-of-outer-ones")
class TakesTheTimeOfOthers(ChangedServices):
    def change_client(self, client: Any) -> None:
        wait = client._waiting.wait

        def wait_longer(done: Any, timeout_s: float) -> Any:
            self.executor._waits_end_ns = 1 << 62
            return wait(done, timeout_s)

        client._waiting.wait = wait_longer


@breaks("stops-end-calls")
class CallsAStopATimeout(ChangedServices):
    def change_client(self, client: Any) -> None:
        def call_on(call: Any, *arguments: Any, **options: Any) -> Any:
            try:
                return call(*arguments, **options)
            except ServiceStoppedError as error:
                raise ServiceTimeoutError(str(error)) from None

        client.call = partial(call_on, client.call)


@breaks("destroyed-clients-end-their-calls")
class KeepsClients(ChangedServices):
    def destroy_client(self, client: Any) -> None:
        pass


@breaks("destroyed-clients-end-their-calls")
class IsReadyForDestroyedClients(ChangedServices):
    def change_client(self, client: Any) -> None:
        registry, name = self._bus.services, client.service_name
        client.service_is_ready = lambda: registry.is_served(name)


@breaks("destroyed-clients-end-their-calls")
class WaitsForDestroyedClients(ChangedServices):
    def change_client(self, client: Any) -> None:
        client.wait_for_service = lambda: False


@breaks("closed-backends-end-services")
class LeavesCallsAtTheEnd(ChangedServices):
    def close(self) -> None:
        self._clients.clear()
        self._services.clear()
        super().close()


@breaks("closed-backends-end-services")
class ServesAgain(ChangedServices):
    def close(self) -> None:
        super().close()
        self._closed = False
