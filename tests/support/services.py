"""A type of services, and backends that other threads spin."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from attrs import field, frozen

from rosbase.contracts.backend import Backend


class Double:
    """Asks for twice a number."""

    @frozen
    class Request:
        number: int = 0

    @frozen
    class Response:
        number: int = 0
        texts: "list[str]" = field(factory=list)


class Other:
    """Another type."""

    @frozen
    class Request:
        pass

    @frozen
    class Response:
        text: str


def double(request: Double.Request) -> Double.Response:
    return Double.Response(2 * request.number)


@contextmanager
def spun(*backends: Backend) -> Iterator[None]:
    """Spins each backend on a thread of its own."""
    done, ready = threading.Event(), threading.Semaphore(0)

    def spin(backend: Backend) -> None:
        # Until then, it belongs to the thread that has made it.
        backend.spin_until(0, done.is_set)
        ready.release()
        while not done.is_set():
            backend.spin_once(0.05)

    threads = [threading.Thread(target=spin, args=(backend,)) for backend in backends]
    for thread in threads:
        thread.start()
    for _ in threads:
        ready.acquire()
    try:
        yield
    finally:
        done.set()
        for thread in threads:
            thread.join()
