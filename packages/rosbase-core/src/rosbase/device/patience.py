"""Retries for a device that is busy for a moment."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rosbase.contracts.transport import TransportContext
from rosbase.device.device import Device, OpenDevice
from rosbase.errors import TransportError

__all__ = ["Patience"]

# `open` may take 5 seconds, and the last try a second or two of them.
_PATIENCE_S = 3.0
_PAUSE_S = 0.1


class Patience:
    """Retries for some seconds if the reason for a failure usually passes.

    Some desktop services open every new port for a second or two; a device on a network may be
    about to start.
    """

    def __init__(self, context: TransportContext) -> None:
        """Start without waiting."""
        self._context = context
        self._enders = 0
        self._enders_lock = threading.Lock()

    def open(self, open_device: OpenDevice) -> Device:
        """Return the device from `open_device`.

        Raises:
            TransportError: From `open_device`; after retries, the last one.
        """
        clock, logger = self._context.clock, self._context.logger
        deadline_ns = clock.monotonic_ns() + int(_PATIENCE_S * 1e9)
        has_said = False
        while True:
            try:
                return open_device()
            except TransportError as error:
                in_time = clock.monotonic_ns() < deadline_ns
                if not (error.passes_soon and in_time and self._pauses()):
                    raise
                if not has_said:
                    logger.warning(f"{error}; trying again for {_PATIENCE_S:g} s")
                    has_said = True

    @contextmanager
    def ending(self) -> Iterator[None]:
        """End an `open` on another thread at once instead of waiting, within the block."""
        with self._enders_lock:
            self._enders += 1
        try:
            yield
        finally:
            with self._enders_lock:
                self._enders -= 1

    def _pauses(self) -> bool:
        """Wait before the next try; return False if another thread wants to end."""
        if not self._enders:
            self._context.clock.sleep(_PAUSE_S)
        return not self._enders
