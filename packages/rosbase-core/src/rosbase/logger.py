"""The logger of the four roles: the standard library's, with `once` and a throttle."""

import logging
import sys
import threading
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase.clock import Clock, SystemClock

__all__ = ["RosbaseLogger", "make_logger"]

_NS_PER_S = 1_000_000_000
# From so many on, those whose time is over are forgotten.
_MANY_KEYS = 1000


class RosbaseLogger:
    """Writes records of `logging.getLogger("rosbase.<name>")`.

    Handlers, levels and formats are the application's, as everywhere in Python. Where it has
    set up none at all, what is INFO or worse goes to stderr, as users of ROS expect.
    """

    def __init__(self, name: str, clock: Clock | None = None) -> None:
        """Takes the name that the records carry, and the clock that throttles."""
        self.name = name
        self._logger = logging.getLogger(f"rosbase.{name}")
        self._clock = clock or SystemClock()
        self._said: set[tuple[int, str]] = set()
        self._next_ns: dict[str, int] = {}
        self._lock = threading.Lock()

    def debug(self, message: str, *, once: bool = False) -> None:
        """For those who look for a fault."""
        self._log(logging.DEBUG, message, once)

    def info(self, message: str, *, once: bool = False) -> None:
        """What goes as it should."""
        self._log(logging.INFO, message, once)

    def warning(self, message: str, *, once: bool = False) -> None:
        """What does not, while the work goes on."""
        self._log(logging.WARNING, message, once)

    def error(self, message: str, *, once: bool = False, exc_info: Any = None) -> None:
        """What stopped some work; `exc_info` as in `logging`, for a traceback."""
        self._log(logging.ERROR, message, once, exc_info)

    def critical(self, message: str, *, once: bool = False) -> None:
        """What stopped all of it."""
        self._log(logging.CRITICAL, message, once)

    def important(self, message: str, level: str = "INFO") -> None:
        """A message that should stand out."""
        self._log(_level(level), f"*** {message} ***")

    def log_once(self, message: str, level: str = "INFO") -> None:
        """The same message at the same level is written only the first time."""
        self._log(_level(level), message, once=True)

    def log_throttle(self, message: str, seconds: float, level: str = "INFO") -> None:
        """The same message is written at most once in that many seconds."""
        if self.due(message, seconds):
            self._log(_level(level), message)

    def due(self, key: str, seconds: float) -> bool:
        """Whether something under `key` may be written again, at most once in `seconds`.

        For messages that change with every call, and should be throttled together.
        """
        now_ns = self._clock.monotonic_ns()
        with self._lock:
            if now_ns < self._next_ns.get(key, now_ns):
                return False
            if len(self._next_ns) >= _MANY_KEYS:
                self._next_ns = {k: due for k, due in self._next_ns.items() if due > now_ns}
            self._next_ns[key] = now_ns + int(seconds * _NS_PER_S)
            return True

    def reset(self) -> None:
        """Forgets which messages have been written once, and every throttle."""
        with self._lock:
            self._said.clear()
            self._next_ns.clear()

    def _log(self, level: int, message: str, once: bool = False, exc_info: Any = None) -> None:
        if not self._is_enabled(level) or (once and not self._first_time(level, message)):
            return
        self._emit(level, message, exc_info)

    @property
    def level(self) -> int:
        """The least level that is written, as a number of `logging`."""
        return self._logger.getEffectiveLevel() if self._logger.hasHandlers() else logging.INFO

    def _emit(self, level: int, message: str, exc_info: Any) -> None:
        if self._logger.hasHandlers():
            self._logger.log(level, "%s", message, exc_info=exc_info, stacklevel=4)
        else:
            text = f"[{logging.getLevelName(level)}] [{self.name}]: {message}"
            _write_to_stderr(_with_traceback(text, exc_info))

    def _is_enabled(self, level: int) -> bool:
        if self._logger.hasHandlers():
            return self._logger.isEnabledFor(level)
        return level >= logging.INFO

    def _first_time(self, level: int, message: str) -> bool:
        with self._lock:
            if (level, message) in self._said:
                return False
            self._said.add((level, message))
            return True


class _CustomLogger(RosbaseLogger):
    """A logger of the application's own, with whatever ours can do and it cannot."""

    def __init__(self, name: str, custom: Any, clock: Clock | None) -> None:
        super().__init__(name, clock)
        self._custom = custom
        for level in (
            logging.DEBUG,
            logging.INFO,
            logging.WARNING,
            logging.ERROR,
            logging.CRITICAL,
        ):
            setattr(self, logging.getLevelName(level).lower(), partial(self._say, level))
        for method in ("important", "log_once"):
            if hasattr(custom, method):
                setattr(self, method, getattr(custom, method))

    def __getattr__(self, attribute: str) -> Any:
        if attribute == "_custom":
            # A copy in the making asks for it before it is there.
            raise AttributeError(attribute)
        return getattr(self._custom, attribute)

    def reset(self) -> None:
        """Forgets what has been written once, here and there."""
        super().reset()
        if hasattr(self._custom, "reset"):
            self._custom.reset()

    def _say(
        self, level: int, message: str, *more: Any, once: bool = False, **options: Any
    ) -> None:
        """Writes a message, with whatever else the application's own logger takes."""
        if not once or self._first_time(level, message):
            self._emit(level, message, options.pop("exc_info", None), *more, **options)

    def _is_enabled(self, level: int) -> bool:
        return True

    def _emit(self, level: int, message: str, exc_info: Any, *more: Any, **options: Any) -> None:
        try:
            write = getattr(self._custom, logging.getLevelName(level).lower())
            write(_with_traceback(message, exc_info), *more, **options)
        except Exception:
            # Whatever is being reported matters more than how.
            super()._emit(level, message, None)


def make_logger(
    name: str, custom: Callable[[str], Any] | None = None, clock: Clock | None = None
) -> RosbaseLogger:
    """The logger of that name; `custom` is a class of the application's own for it."""
    if custom is None:
        return RosbaseLogger(name, clock)
    logger = custom(name)
    if not isinstance(logger, RosbaseLogger):
        return _CustomLogger(name, logger, clock)
    if clock is not None:
        # Made with the name alone, it cannot know which time counts here.
        logger._clock = clock
    return logger


def _with_traceback(message: str, exc_info: Any) -> str:
    if not isinstance(exc_info, BaseException):
        return message
    return f"{message}\n{''.join(traceback.format_exception(exc_info)).rstrip()}"


def _write_to_stderr(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError):
        # Nobody can hear it: stderr is closed, or its reader has gone.
        pass


def _level(name: str) -> int:
    level = logging.getLevelNamesMapping().get(name.upper())
    if level is None:
        raise ValueError(f"no log level is called {name!r}")
    return level
