"""How a mutant is written: a good transport, of which something is overridden."""

import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rosbase.contracts.transport import OnFrame, Transport, TransportContext, TransportHealth
from rosbase.parameters import ParameterValue
from support.fifo import FifoContract, make_transport

__all__ = [
    "LEAKED",
    "MUTANTS",
    "RELEASE",
    "KeepsSubscriber",
    "Mutant",
    "Wrapped",
    "mutant",
    "wait_for_release",
]

RELEASE = threading.Event()
"""Ends whatever a mutant would do for ever."""
LEAKED: list[int] = []
"""Descriptors that a mutant has not closed."""
_FOR_EVER_S = 30.0


def wait_for_release() -> None:
    """Hangs, until the test has seen enough."""
    RELEASE.wait(_FOR_EVER_S)


class Mutant(NamedTuple):
    """What is wrong, which promise that breaks, and what the kit must have seen."""

    promise: str
    seen: str
    name: str
    contract: type[FifoContract]


MUTANTS: list[Mutant] = []


class Wrapped(Transport):
    """A good transport, passed through."""

    def __init__(self, values: Mapping[str, ParameterValue], context: TransportContext) -> None:
        self.values = values
        self.context = context
        self.inner = self.make()
        self.prepare()

    def prepare(self) -> None:
        """What a mutant does when it is made."""

    def make(self) -> Transport:
        return make_transport(self.values, self.context)

    def open(self) -> None:
        self.inner.open()

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(on_frame)

    def stop(self) -> None:
        self.inner.stop()

    def close(self) -> None:
        self.inner.close()

    @property
    def is_open(self) -> bool:
        return self.inner.is_open

    @property
    def health(self) -> TransportHealth:
        return self.inner.health


class KeepsSubscriber(Wrapped):
    """Has what it was started with, to call it when it should not."""

    on_frame: OnFrame | None = None

    def start(self, on_frame: OnFrame) -> None:
        self.on_frame = on_frame
        self.inner.start(on_frame)


def mutant(promise: str, seen: str) -> Callable[[type[Any]], type[Any]]:
    """Registers a mutant: a transport, or a contract whose author has made a mistake.

    Args:
        promise: Which one is broken.
        seen: A part of what the kit says that it has seen.
    """

    def register(kind: type[Any]) -> type[Any]:
        contract = kind if issubclass(kind, FifoContract) else _contract(kind)
        MUTANTS.append(Mutant(promise, seen, kind.__name__, contract))
        return kind

    return register


def _contract(kind: type[Wrapped]) -> type[FifoContract]:
    class MutantContract(FifoContract):
        """Impatient, because what does not come never will."""

        call_limit_s = 0.6
        end_limit_s = 0.4
        patience_s = 0.6
        reconnect_limit_s = 0.8
        cycles = 5
        machine_examples = 200

        def make_transport(self, peer: Any, context: TransportContext) -> Transport:
            return kind({"wait": False, **peer.parameters}, context)

    return MutantContract
