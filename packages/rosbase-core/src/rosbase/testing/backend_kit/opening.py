"""Checks of a new backend."""

import logging
from functools import partial

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.errors import BackendError
from rosbase.lifecycle import State
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.runtime.executor import Executor
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig
from rosbase.testing.clock import ManualClock

__all__ = ["OpeningChecks"]

_LIFE = ("configure", "activate", "deactivate", "cleanup", "shutdown")
# Levels and texts that not every world can send.
_RECORDS = [(20, "ready"), (40, "a\0b \ud800 ä"), (1, "least"), (25, "odd"), (400, "")]


class OpeningChecks(BackendRig):
    """Checks of a backend before anything is created."""

    def test_opens(self) -> None:
        promised = promise("opens")
        backend = self.open()
        name = backend.node_name.rpartition("/")[2]
        promised.require(name == "kit", f"the node_name of `kit` is {backend.node_name!r}")

    def test_wrong_node_names_are_errors(self) -> None:
        promised = promise("wrong-node-names-are-errors")
        for name in ("my-robot", "a/b", "1st", "", "n" * 221):
            self.refuses(
                promised,
                BackendError,
                partial(self._open_and_close, BackendOptions(name)),
                f"a backend of the node {name[:20]!r}",
                name[:20],
            )

    def test_leaves_the_executor_alone(self) -> None:
        promised = promise("leaves-the-executor-alone")
        backend = self.open()
        promised.require(
            type(backend.executor) is Executor, f"executor is {type(backend.executor).__name__}"
        )
        for name in ("call_soon", "spin_once", "spin_until"):
            promised.require(
                getattr(backend, name) == getattr(backend.executor, name),
                f"{name} is not the executor's",
            )

    def test_takes_a_clock(self) -> None:
        self.needs("takes_a_clock")
        promised, clock = promise("takes-a-clock"), ManualClock()
        backend = self.open(clock)
        clock.advance(100.0)
        promised.require(
            backend.clock.now_ns() == clock.now_ns(),
            f"its date is {backend.clock.now()}, not {clock.now()}",
        )
        calls: list[int] = []
        backend.create_timer(3.0, lambda: calls.append(clock.elapsed_ns))
        backend.spin_until(clock.monotonic_ns() + 10_000_000_000, lambda: False)
        expected = [103_000_000_000, 106_000_000_000, 109_000_000_000]
        promised.require(calls == expected, f"a timer of 3 s, set at 100 s, was called at {calls}")

    def test_lifecycle_nodes_are_exposed(self) -> None:
        promised = promise("lifecycle-nodes-are-exposed")
        backend = self.open()
        for _ in range(2):
            self.raises_nothing(
                promised, lambda: self._live(backend), "a lifecycle node on this backend"
            )

    def test_log_handler_raises_nothing(self) -> None:
        promised = promise("log-handler-raises-nothing")
        self.needs("has_log_handler")
        backend = self.open()
        promised.require(
            isinstance(backend.log_handler, logging.Handler),
            f"log_handler is {backend.log_handler!r}",
        )
        self.on_thread(promised, lambda: _log(backend), "log_handler, on another thread,")
        backend.close()
        self.raises_nothing(promised, lambda: _log(backend), "log_handler, after close,")

    def _open_and_close(self, options: BackendOptions) -> None:
        self.make_backend(options).close()

    def _live(self, backend: Backend) -> None:
        node = LifecycleNode(backend=backend)
        for label in _LIFE:
            node.request_transition(label=label)
        state = node.get_state()
        promise("lifecycle-nodes-are-exposed").require(
            state is State.FINALIZED, f"after {', '.join(_LIFE)} it is {state.label}"
        )


def _log(backend: Backend) -> None:
    assert backend.log_handler is not None
    for level, text in _RECORDS:
        backend.log_handler.handle(
            logging.LogRecord("kit", level, __file__, 1, text, None, None, "check")
        )
