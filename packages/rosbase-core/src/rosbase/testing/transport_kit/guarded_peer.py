"""Peer with a timeout for its calls: a dead reader must not hang the test."""

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
    """Peer whose calls run on a thread of their own; a call that hangs breaks the promise."""

    def __init__(self, peer: FullPeer, promise: Promise, limit_s: float) -> None:
        """Wrap the peer that an author has made."""
        self.made = peer
        """Peer of the author."""
        self._promise = promise
        self._limit_s = limit_s
        self._caller = Caller()

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Parameters with which the transport reaches this device."""
        return dict(self._call("parameters", lambda: self.made.parameters))

    def send(self, *payloads: bytes) -> None:
        """Send payloads, one by one."""
        for payload in payloads:
            self._call("send", self.made.send, payload)

    def send_raw(self, data: bytes) -> None:
        """Send raw bytes."""
        self._call("send_raw", self.made.send_raw, data)

    def encode(self, payload: bytes) -> bytes:
        """Return the bytes that `send` sends."""
        encoded: bytes = self._call("encode", self.made.encode, payload)
        return encoded

    def unplug(self) -> None:
        """Unplug the device."""
        self._call("unplug", self.made.unplug)

    def replug(self) -> None:
        """Plug the device in again."""
        self._call("replug", self.made.replug)

    @property
    def threads(self) -> set[threading.Thread]:
        """Threads from which it is called."""
        return self._caller.threads

    def close(self) -> None:
        """End the link."""
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
