"""Choose where a record goes: to the application's handlers, if it has any, else to the console.

If a library calls `logging.info()`, Python sets up logging with a handler for stderr, at WARNING.
Nobody has chosen that, so it does not count. A handler that writes nothing does not count either.
Every other handler belongs to the application, and decides about format and level as everywhere in
Python.
"""

import logging
import sys

from rosbase.logger.console import Console

__all__ = ["survey"]

_OURS = "rosbase"


def survey(logger: logging.Logger) -> tuple[bool, int]:
    """Look at the loggers from this one up to the root.

    Returns:
        Whether a record reaches a handler of the application. Also the level that was set for this
        logger or for all of rosbase's, 0 if none was. The root's level does not count: its default
        is WARNING, and libraries change it.
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
