"""Who decides about a record: the application, if it has set up logging, else the console.

A library that calls `logging.info()` has Python set up logging behind everybody's back: with a
handler for stderr, and at WARNING. That is nobody's decision, so it does not count. Neither does
a handler that writes nothing. Every other handler is the application's, and decides about format
and level as everywhere in Python.
"""

import logging
import sys

from rosbase.logger.console import Console

__all__ = ["survey"]

_OURS = "rosbase"


def survey(logger: logging.Logger) -> tuple[bool, int]:
    """Look at the loggers from this one up to the root.

    Returns:
        Whether a record reaches a handler that the application has set up; and the level that was
        set for this logger or for all of rosbase's, 0 if none was. The root's level does not count:
        its default is WARNING, and libraries change it.
    """
    is_applications, is_passed_on, level = False, True, logging.NOTSET
    at: logging.Logger | None = logger
    while at is not None:
        if at.handlers and is_passed_on and not is_applications:
            is_applications = any(not _is_nobodys(handler, at) for handler in at.handlers)
        is_passed_on = is_passed_on and at.propagate
        parent = at.parent
        if not level and parent is not None:
            level = at.level
        at = parent
    return is_applications, level


def _is_nobodys(handler: logging.Handler, logger: logging.Logger) -> bool:
    if isinstance(handler, Console):
        return True
    if logger.parent is not None:
        return False
    return isinstance(handler, logging.NullHandler) or _is_by_default(handler, logger)


def _is_by_default(handler: logging.Handler, root: logging.Logger) -> bool:
    """Return whether `logging.basicConfig()` without arguments leaves such a handler."""
    formatter = handler.formatter
    return (
        type(handler) is logging.StreamHandler
        and root.level == logging.WARNING
        and handler.level == logging.NOTSET
        and not handler.filters
        and type(formatter) is logging.Formatter
        and (formatter._fmt, formatter.datefmt) == (logging.BASIC_FORMAT, None)
        and (handler.stream in (sys.stderr, sys.__stderr__) or _is_stderr(handler.stream))
    )


def _is_stderr(stream: object) -> bool:
    return getattr(stream, "name", "") == "<stderr>"
