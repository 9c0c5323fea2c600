"""Functions that hear every record of rosbase's loggers, wherever else it goes."""

import logging
from collections.abc import Callable
from typing import TypeAlias

__all__ = ["Observer", "add_observer", "observers", "remove_observer"]

Observer: TypeAlias = Callable[[logging.LogRecord], object]

observers: list[Observer] = []
"""The functions. Loop over a copy, because any thread may add one."""


def add_observer(function: Observer) -> None:
    """Have the function hear every record from now on. Call it from any thread.

    It is called on any thread, after the record has gone where it goes. It must be quick and must
    not raise.
    """
    observers.append(function)


def remove_observer(function: Observer) -> None:
    """Have the function hear no more. Do nothing if it hears nothing."""
    if function in observers:
        observers.remove(function)
