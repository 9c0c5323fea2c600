"""What is wrong as soon as it is opened."""

from collections.abc import Callable
from logging import LogRecord, NullHandler

from attrs import evolve

from rosbase.clock import SystemClock
from rosbase.contracts.backend import Backend, BackendOptions, Timer
from rosbase.errors import BackendError
from rosbase.lifecycle import ManagedNode
from rosbase.local import LocalBackend
from rosbase.runtime.executor import Executor
from support.backend_mutants.changed import breaks


@breaks("opens")
class Unfinished(Backend):
    pass


@breaks("opens")
class GoesByAnotherName(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(evolve(options, node_name="somebody"))


@breaks("wrong-node-names-are-errors")
class TakesAnyName(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(evolve(options, node_name=options.node_name[:7].strip("-/1") or "node"))


@breaks("leaves-the-executor-alone")
class SpinsByItself(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.spin_once = lambda timeout_s: False


@breaks("leaves-the-executor-alone")
class HasAnExecutorOfItsOwn(LocalBackend):
    class OwnExecutor(Executor):
        pass

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.executor = self.OwnExecutor(options.clock)


@breaks("takes-a-clock")
class HasTheTimeOfTheMachine(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(evolve(options, clock=SystemClock()))


@breaks("takes-a-clock")
class StampsByAnotherClock(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.clock = SystemClock()


@breaks("takes-a-clock")
class TakesItsTime(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return super().create_timer(2 * period_s, callback)


@breaks("lifecycle-nodes-are-exposed")
class HasRoomForOneLifecycle(LocalBackend):
    exposed: ManagedNode | None = None

    def expose_lifecycle(self, node: ManagedNode) -> None:
        if self.exposed:
            raise BackendError("one lifecycle node is enough")
        self.exposed = node


@breaks("log-handler-raises-nothing")
class TroublesWhoLogsLate(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.log_handler = handler = NullHandler()

        def handle(record: LogRecord) -> bool:
            if self._closed:
                raise BackendError("the backend is closed")
            return True

        handler.handle = handle  # type: ignore[method-assign]  # which is what is wrong


@breaks("log-handler-raises-nothing")
class HasNoLogHandler(LocalBackend):
    pass
