"""One function that hears every record of rosbase's loggers, wherever else they go."""

import logging
from collections.abc import Callable

__all__ = ["observe", "observers"]

observers: list[Callable[[logging.LogRecord], object]] = []
"""The function, or nothing."""


def observe(function: Callable[[logging.LogRecord], object] | None) -> None:
    """Have the function hear every record from now on; None ends it.

    It is called on any thread, after the record has gone where it goes. It must be quick and must
    not raise. A program without a control socket has none.
    """
    observers[:] = [] if function is None else [function]
