"""Transport with a timeout for its calls; a call that hangs breaks a promise."""

import threading
from collections.abc import Callable
from typing import Any

from attrs import frozen

from rosbase.contracts.transport import OnFrame, Transport, TransportHealth, TransportState
from rosbase.errors import TransportError
from rosbase.testing.promise import Promise
from rosbase.testing.seen import not_written, raised
from rosbase.testing.transport_kit.caller import Caller, StillRunningError
from rosbase.testing.transport_kit.promises import CALLS

__all__ = ["GuardedTransport", "Limits"]


@frozen
class Limits:
    """Limits of calls, in seconds."""

    call_s: float
    """Limit of `open` and `start`."""
    end_s: float
    """Limit of `stop`, `close`, and each read of `health` and `is_open`."""


class GuardedTransport:
    """Transport whose calls run on one thread, each with a limit; another thread reads its health.

    A call that raises or does not return breaks a promise.
    """

    def __init__(self, transport: Transport, promise: Promise, limits: Limits) -> None:
        """Wrap the transport that an author has made."""
        self.made = transport
        """Transport of the author."""
        self._promise = promise
        self._limits = limits
        self._caller, self._looker = Caller(), Caller()

    def open(self) -> None:
        """Open it."""
        self._call("open", self.made.open, self._limits.call_s)

    def start(self, on_frame: OnFrame) -> None:
        """Start it."""
        self._call("start", lambda: self.made.start(on_frame), self._limits.call_s)

    def stop(self, limit_s: float | None = None) -> None:
        """Stop it, within another limit if one is given."""
        self._call("stop", self.made.stop, limit_s or self._limits.end_s)

    def close(self, limit_s: float | None = None) -> None:
        """Close it, within another limit if one is given."""
        self._call("close", self.made.close, limit_s or self._limits.end_s)

    def refusal(self, name: str, *arguments: object) -> TransportError | None:
        """Return the error that `open` or `start` raises; None if it raises none."""
        call = getattr(self.made, name)
        try:
            self._run(name, lambda: call(*arguments), self._limits.call_s)
        except TransportError as error:
            return error
        return None

    @property
    def is_open(self) -> bool:
        """Value from the transport."""
        return bool(self._look("is_open", lambda: self.made.is_open))

    @property
    def health(self) -> TransportHealth:
        """Value from the transport."""
        health = self._look("health", lambda: self.made.health)
        CALLS.require(
            isinstance(health, TransportHealth), f"health gave {health!r}, not a TransportHealth"
        )
        return health  # type: ignore[no-any-return]  # just checked

    @property
    def state(self) -> TransportState:
        """State in its health."""
        return self.health.state

    @property
    def threads(self) -> set[threading.Thread]:
        """Threads from which it is called."""
        return self._caller.threads | self._looker.threads

    def release(self) -> None:
        """Close it at the end of a check, ignoring errors, and end the threads."""
        try:
            self._caller.run(self.made.close, self._limits.call_s)
        except Exception:
            # Another check needs a close that works; this one has already reported.
            pass
        self._caller.close()
        self._looker.close()

    def _call(self, name: str, call: Callable[[], object], limit_s: float) -> None:
        try:
            self._run(name, call, limit_s)
        except TransportError as error:
            raise self._promise.broken(raised(f"{name}()", error)) from error

    def _run(self, name: str, call: Callable[[], object], limit_s: float) -> Any:
        try:
            return self._caller.run(call, limit_s)
        except StillRunningError as error:
            raise self._promise.broken(f"{name}() {error}") from None
        except TransportError:
            raise
        except NotImplementedError as error:
            raise CALLS.broken(not_written(name, error)) from error
        except BaseException as error:
            raise self._promise.broken(raised(f"{name}()", error)) from error

    def _look(self, name: str, look: Callable[[], Any]) -> Any:
        try:
            return self._looker.run(look, self._limits.end_s)
        except StillRunningError as error:
            raise self._promise.broken(f"{name} {error}") from None
        except NotImplementedError as error:
            raise CALLS.broken(not_written(name, error)) from error
        except Exception as error:
            raise self._promise.broken(raised(name, error)) from error
