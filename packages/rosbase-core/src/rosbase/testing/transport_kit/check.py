"""Decorator for checks of the transport contract: methods that take a bench."""

from collections.abc import Callable
from typing import Any, TypeVar

import pytest

from rosbase.testing.promise import BrokenPromiseError
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.promised import promise_of
from rosbase.testing.transport_kit.promises import PAGE

__all__ = ["check"]

AuthorT = TypeVar("AuthorT", bound=TransportAuthor)


def check(
    *needs: str,
) -> Callable[[Callable[[AuthorT, Bench], None]], Callable[[AuthorT], None]]:
    """Make a test of a method; its name and docstring are the promise.

    Args:
        needs: The capabilities without which the test is skipped.
    """

    def decorate(method: Callable[[AuthorT, Bench], None]) -> Callable[[AuthorT], None]:
        promise = promise_of(method, PAGE)

        def run(self: AuthorT) -> None:
            for need in needs:
                if not getattr(self.capabilities, need):
                    pytest.skip(f"TransportCapabilities.{need} is not declared")
            bench = Bench(self, promise)
            try:
                method(self, bench)
            except BrokenPromiseError:
                # Whatever the check saw, unimplemented code is the cause.
                bench.require_written()
                raise
            finally:
                bench.close()
            # Only now, because close may be the unimplemented call.
            bench.require_written()

        run.__name__, run.__qualname__ = method.__name__, method.__qualname__
        run.__doc__, run.__module__ = method.__doc__, method.__module__
        as_any: Any = run
        as_any.promise = promise
        as_any.needs = needs
        return run

    return decorate
