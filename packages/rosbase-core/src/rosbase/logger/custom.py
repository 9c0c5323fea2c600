"""A logger class of the application, with the methods of rosbase's logger added."""

import logging
from collections.abc import Callable
from functools import partial
from typing import Any, cast

from rosbase.clock import Clock
from rosbase.logger.call_sites import calling_frame, site_of
from rosbase.logger.dates import is_dropped
from rosbase.logger.destination import survey
from rosbase.logger.filters import FILTERS, LogOptions
from rosbase.logger.levels import level_named, level_number
from rosbase.logger.record_text import show, whole_text
from rosbase.logger.rosbase_logger import RosbaseLogger
from rosbase.text.printable import log_line

__all__ = ["make_logger"]

# A method, its level, and what it is called in loggers that do not have it.
_METHODS = {
    "debug": (logging.DEBUG, "debug"),
    "info": (logging.INFO, "info"),
    "warning": (logging.WARNING, "warn"),
    "warn": (logging.WARNING, "warning"),
    "error": (logging.ERROR, "error"),
    "exception": (logging.ERROR, "error"),
    "critical": (logging.CRITICAL, "fatal"),
    "fatal": (logging.CRITICAL, "critical"),
}
_WHOLE = ("get_child", "get_effective_level", "is_enabled_for", "set_level")


class _CustomLogger(RosbaseLogger):
    """Wraps a logger of the application, and adds the methods that it lacks."""

    def __init__(
        self,
        name: str,
        custom: Any,
        clock: Clock | None,
        listener: logging.Handler | None,
        *,
        has_console: bool,
    ) -> None:
        super().__init__(name, clock, listener, has_console=has_console)
        self._custom, self._least = custom, logging.NOTSET
        for method in _METHODS:
            setattr(self, method, partial(self._say, method))
        for method in ("important", "log_once"):
            if hasattr(custom, method):
                setattr(self, method, partial(self._say_its_way, method))
        for method in _WHOLE:
            if hasattr(custom, method):
                setattr(self, method, getattr(custom, method))

    def __getattr__(self, attribute: str) -> Any:
        if attribute == "_custom":
            # A copy in the making asks for it before it is there.
            raise AttributeError(attribute)
        return getattr(self._custom, attribute)

    def reset(self) -> None:
        """Forget the calls logged once, in both loggers."""
        super().reset()
        if hasattr(self._custom, "reset"):
            self._custom.reset()

    def set_level(self, level: str | int) -> None:
        """Set the minimum level of the application's logger, even if it has no such method."""
        self._least = level_number(level)

    def get_effective_level(self) -> int:
        """Return the level that was set, or the listener's."""
        return self._least or self._default_level

    def _way(self, level: int) -> bool | None:
        return True if level >= self._least else None

    def _say(self, method: str, message: Any, *more: Any, **options: Any) -> None:
        """Write a message, with all arguments that the application's own logger takes."""
        level, frame = _METHODS[method][0], calling_frame()
        if self._way(level) is None or is_dropped():
            return
        filters = {name: options.pop(name) for name in FILTERS & options.keys()}
        if filters and not self._filters.pass_on(
            site_of(frame), level, cast("LogOptions", filters), self._clock
        ):
            return
        message = _cleaned(message)
        said = LogOptions(exc_info=options.pop("exc_info", method == "exception"))
        record = self._record_of(level, log_line(show(_fill_in(message, more))), frame, said)
        text = f"{message}\n{record.exc_text}" if record.exc_text else message
        self._write(method, text, more, options, record)
        self._hand_on(record)

    def _say_its_way(self, method: str, message: str, *more: Any, **options: Any) -> Any:
        """Write in a way that only the application's logger has, at a level if it takes one."""
        message = _cleaned(message)
        answer = getattr(self._custom, method)(message, *more, **options)
        named = str(options.get("level", more[0] if more else ""))
        level = level_named(named)
        level = logging.INFO if level is None else level
        if method != "log_once" or self._first_time(level, message):
            self._hand_on(self._record_of(level, log_line(show(message)), calling_frame(), {}))
        return answer

    def _write(
        self,
        method: str,
        text: Any,
        more: tuple[Any, ...],
        options: Any,
        record: logging.LogRecord,
    ) -> None:
        other = _METHODS[method][1]
        try:
            write = getattr(self._custom, method, None) or getattr(self._custom, other)
            write(text, *more, **options)
        except Exception:
            # Whatever is being reported matters more than how.
            super()._emit(record, is_applications=survey(self._logger)[0])

    def _emit(self, record: logging.LogRecord, *, is_applications: bool) -> None:
        """Write a message that one of our methods has prepared."""
        levels = {level: method for method, (level, _) in reversed(_METHODS.items())}
        self._write(levels.get(record.levelno, "info"), whole_text(record), (), {}, record)

    def _hand_on(self, record: logging.LogRecord) -> None:
        # What the application's own logger writes is its affair; who listens has a level too.
        if record.levelno >= self._default_level:
            super()._hand_on(record)


def make_logger(
    name: str,
    custom: Callable[[str], Any] | None = None,
    clock: Clock | None = None,
    listener: logging.Handler | None = None,
    *,
    has_console: bool = True,
) -> RosbaseLogger:
    """Return the logger of that name.

    Args:
        name: Name of its records.
        custom: A class of the application, which is called with the name.
        clock: Clock for throttling.
        listener: A backend's handler, which gets the records beside the console.
        has_console: Whether the console gets records too. A custom logger decides by itself.
    """
    if custom is None:
        return RosbaseLogger(name, clock, listener, has_console=has_console)
    logger = custom(name)
    if not isinstance(logger, RosbaseLogger):
        return _CustomLogger(name, logger, clock, listener, has_console=has_console)
    # Made with the name alone, it cannot know which time counts here, and who listens.
    if clock is not None:
        logger._clock = clock
    logger._have_listen(listener, has_console=has_console)
    return logger


def _fill_in(message: Any, values: tuple[Any, ...]) -> Any:
    """Return the text as `logging` wants it if the logger takes values; else with colours."""
    try:
        return message % values if values else message
    except (TypeError, ValueError):
        return message


def _cleaned(message: Any) -> Any:
    """Return a text message as one line; a logger of the application may take other types."""
    return log_line(message) if isinstance(message, str) else message
