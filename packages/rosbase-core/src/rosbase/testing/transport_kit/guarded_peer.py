"""A peer whose calls end: one that waits for a reader that has died would hang the test."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosbase.errors import TransportError
from rosbase.parameters import ParameterValue
from rosbase.testing.promise import Promise
from rosbase.testing.seen import not_written, raised
from rosbase.testing.transport_kit.caller import Caller, StillRunningError
from rosbase.testing.transport_kit.capabilities import FullPeer
from rosbase.testing.transport_kit.promises import PEER

__all__ = ["GuardedPeer"]


class GuardedPeer:
    """Makes the calls of a peer on a thread of its own, and says what was promised if they hang."""

    def __init__(self, peer: FullPeer, promise: Promise, limit_s: float) -> None:
        """Takes over the peer that an author has made."""
        self.made = peer
        """What the author has made."""
        self._promise = promise
        self._limit_s = limit_s
        self._caller = Caller()

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """What the transport must be given to reach this device."""
        return dict(self._call("parameters", lambda: self.made.parameters))

    def send(self, *payloads: bytes) -> None:
        """Sends payloads, one by one."""
        for payload in payloads:
            self._call("send", self.made.send, payload)

    def send_raw(self, data: bytes) -> None:
        """Sends bytes as they are."""
        self._call("send_raw", self.made.send_raw, data)

    def encode(self, payload: bytes) -> bytes:
        """The bytes that `send` sends."""
        encoded: bytes = self._call("encode", self.made.encode, payload)
        return encoded

    def unplug(self) -> None:
        """Takes the device away."""
        self._call("unplug", self.made.unplug)

    def replug(self) -> None:
        """Brings it back."""
        self._call("replug", self.made.replug)

    @property
    def threads(self) -> set[threading.Thread]:
        """Those from which it is called."""
        return self._caller.threads

    def close(self) -> None:
        """Ends the link."""
        try:
            self._call("close", self.made.close)
        finally:
            self._caller.close()

    def _call(self, name: str, call: Callable[..., Any], *arguments: object) -> Any:
        try:
            return self._caller.run(lambda: call(*arguments), self._limit_s)
        except StillRunningError as error:
            raise self._promise.broken(
                f"the peer's {name}() {error}: does nobody read what it sends?"
            ) from None
        except TransportError as error:
            raise PEER.broken(raised(f"the peer's {name}()", error)) from error
        except NotImplementedError as error:
            raise PEER.broken(not_written(f"the peer's {name}()", error)) from error
