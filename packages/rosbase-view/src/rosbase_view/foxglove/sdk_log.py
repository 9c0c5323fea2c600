"""The log of foxglove-sdk, on the terminal."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["sdk_log"]

_LOGGER = "foxglove"
# The SDK tells at a low level, and in no other way, that a client loses messages.
_LOSES = "outbox for client "
_MOST_LINES = 100


@contextmanager
def sdk_log() -> Iterator[None]:
    """Print what matters, each line once."""
    logger, handler = logging.getLogger(_LOGGER), _Handler()
    before = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before[0])
        logger.propagate = before[1]


class _Handler(logging.Handler):
    """Is called within the SDK, so it must not call the SDK."""

    def __init__(self) -> None:
        super().__init__()
        self._printed: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if text.startswith(_LOSES):
            client = text.removeprefix(_LOSES).partition(" ")[0]
            text = f"client {client} reads too slowly: it loses the oldest messages"
        elif record.levelno < logging.WARNING:
            return
        # A client may send anything, as often as it likes.
        if text not in self._printed and len(self._printed) < _MOST_LINES:
            self._printed.add(text)
            print(f"rosbase view: {text}", file=sys.stderr, flush=True)
