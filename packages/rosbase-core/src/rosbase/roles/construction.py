"""Constructors of managers and nodes: undone as a whole when they fail or a signal ends them."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.contracts.backend import Backend
from rosbase.roles.shutdown import is_wish
from rosbase.runtime.stopping import StopSignals, stop_on_signals

__all__ = ["Constructed", "constructor"]

InitT = TypeVar("InitT", bound=Callable[..., None])


class Constructed:
    """A class whose whole constructor, including subclasses' parts, is undone if it fails."""

    _is_under_construction = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        init = cls.__init__
        if "__init__" in cls.__dict__ or not getattr(init, "_is_constructor", False):
            # Its own, or inherited from a class outside rosbase.
            cls.__init__ = constructor(cls.__init__)  # type: ignore[method-assign]  # as decorated

    def _missing_base(self) -> str:
        """Say that the constructor has not called its base class's; empty if it has or may."""
        return ""

    def _abandon(self) -> None:
        """Undo the work of the constructor so far."""

    def _end_program(self) -> None:
        """End everything that would keep the program running, because a signal has ended this."""


def constructor(init: InitT) -> InitT:
    """Wrap an `__init__`, so that the outermost one undoes everything if it does not succeed.

    While it runs, SIGINT, SIGTERM and SIGHUP ask for the end: the constructor is undone and
    SystemExit with status 0 is raised.
    """

    @functools.wraps(init)
    def construct(self: Constructed, *args: Any, **kwargs: Any) -> None:
        if self._is_under_construction:
            init(self, *args, **kwargs)
            return
        self._is_under_construction = True
        try:
            if _is_in_virtual_time(kwargs.get("backend")):
                _construct(self, None, lambda: init(self, *args, **kwargs))
                return
            defer = functools.partial(_defer, self)
            with stop_on_signals(_nothing, defer, yields_to_outer=True) as stop:
                _construct(self, stop, lambda: init(self, *args, **kwargs))
            if stop.was_asked:
                # It came while the handlers from before were put back.
                _end_quietly(self, stop)
        finally:
            del self._is_under_construction

    construct._is_constructor = True  # type: ignore[attr-defined]  # for subclasses to see
    return construct  # type: ignore[return-value]  # it has the signature of `init`


def _construct(
    constructed: Constructed, stop: StopSignals | None, init: Callable[[], None]
) -> None:
    try:
        init()
        if lack := constructed._missing_base():
            raise TypeError(lack)
        if stop is None or not stop.was_asked:
            return
    except BaseException as error:
        if not is_wish(error, stop):
            _undo(constructed, stop)
            raise
    _end_quietly(constructed, stop)


def _end_quietly(constructed: Constructed, stop: StopSignals | None) -> None:
    _undo(constructed, stop)
    # Not from the interrupt, which was only the way here.
    raise SystemExit(0) from None


def _undo(constructed: Constructed, stop: StopSignals | None) -> None:
    if stop is not None:
        stop.begin_clean_up()
        if stop.was_asked:
            constructed._end_program()
    constructed._abandon()


def _is_in_virtual_time(backend: object) -> bool:
    return isinstance(backend, Backend) and backend.is_in_virtual_time


def _defer(constructed: Constructed, function: Callable[[], object]) -> None:
    """Run it in a call of a service for which the constructor waits, if it does."""
    backend = constructed.__dict__.get("backend") or constructed.__dict__.get("_backend")
    if isinstance(backend, Backend):
        backend.executor.call_urgently(function)


def _nothing() -> None:
    """Do nothing: while a constructor runs, a request to stop only ends it."""
