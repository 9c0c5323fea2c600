"""The text of a record: a message with its values, and the lines below it."""

import logging
import sys
import traceback
from collections.abc import Mapping
from types import FrameType
from typing import Any

from rosbase.text.printable import indented

__all__ = ["error_of", "fill_in", "show", "stack_of", "traceback_of", "whole_text"]


def fill_in(message: object, values: tuple[object, ...]) -> str:
    """Return the message with its values, as `logging` does. It never raises.

    Without values the message stays as it is. If they do not fit, the text says so.
    """
    text = show(message)
    if not values:
        return text
    is_by_name = len(values) == 1 and isinstance(values[0], Mapping) and values[0]
    try:
        return text % (values[0] if is_by_name else values)
    except Exception as error:
        shown = ", ".join(show(value, repr) for value in values)
        return f"{text} (cannot be formatted with {shown}: {show(error)})"


def show(value: object, how: Any = str) -> str:
    """Return the text of any value, even if its code raises."""
    try:
        return str(how(value))
    except Exception as error:
        return f"<{type(value).__name__} that cannot be shown: {type(error).__name__}>"


def error_of(exc_info: Any) -> BaseException | None:
    """Return the exception of `exc_info`, as in `logging`."""
    if isinstance(exc_info, BaseException):
        return exc_info
    if isinstance(exc_info, tuple):
        return next((part for part in exc_info if isinstance(part, BaseException)), None)
    return sys.exc_info()[1] if exc_info else None


def traceback_of(error: BaseException) -> str:
    """Return the traceback, indented, so that none of its lines looks like a record."""
    try:
        lines = traceback.format_exception(error)
    except Exception as fault:
        lines = [f"{type(error).__name__}, whose traceback cannot be shown: {show(fault)}"]
    return indented("".join(lines).rstrip())


def stack_of(frame: FrameType) -> str:
    """Return the call stack, indented."""
    return indented("Stack (most recent call last):\n" + "".join(traceback.format_stack(frame)))


def whole_text(record: logging.LogRecord) -> str:
    """Return the message with the lines below it."""
    below = (record.exc_text, record.stack_info)
    return "\n".join([record.getMessage(), *(text for text in below if text)])
