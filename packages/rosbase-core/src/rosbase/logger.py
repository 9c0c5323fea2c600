"""The logger of the four roles: the standard library's, with `once` and a throttle."""

import logging
import sys
import threading
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase.clock import Clock, SystemClock
from rosbase.text.printable import indented, log_line

__all__ = ["RosbaseLogger", "make_logger"]

_NS_PER_S = 1_000_000_000
# From so many on, the oldest are forgotten. Their hashes are kept, for a key may be a long text.
_MANY_KEYS = 1000


class RosbaseLogger:
    """Writes records of `logging.getLogger("rosbase.<name>")`.

    Handlers, levels and formats are the application's, as everywhere in Python. Where it has
    set up none at all, what is INFO or worse goes to stderr, as users of ROS expect.

    Each message is one line of printable characters, whoever's text is in it: line ends and
    control characters are written as escapes, and a traceback stands indented below the line.

    A backend may listen. Its handler is none of the application's and changes nothing of that,
    but for the least level that goes to stderr, which is then the handler's.
    """

    def __init__(
        self, name: str, clock: Clock | None = None, listener: logging.Handler | None = None
    ) -> None:
        """Takes the name that the records carry, the clock that throttles, and who listens."""
        self.name = name
        self._logger = logging.getLogger(f"rosbase.{name}")
        self._clock = clock or SystemClock()
        self._have_listen(listener)
        self._said: dict[int, None] = {}
        self._next_ns: dict[int, int] = {}
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
        now_ns, known = self._clock.monotonic_ns(), hash(key)
        with self._lock:
            if now_ns < self._next_ns.get(known, now_ns):
                return False
            if len(self._next_ns) >= _MANY_KEYS:
                self._next_ns = {k: due for k, due in self._next_ns.items() if due > now_ns}
            _make_room(self._next_ns)
            self._next_ns[known] = now_ns + int(seconds * _NS_PER_S)
            return True

    def reset(self) -> None:
        """Forgets which messages have been written once, and every throttle."""
        with self._lock:
            self._said.clear()
            self._next_ns.clear()

    def _log(self, level: int, message: str, once: bool = False, exc_info: Any = None) -> None:
        if not self._is_enabled(level) or (once and not self._first_time(level, message)):
            return
        line = log_line(message)
        self._emit(level, line, exc_info)
        self._hand_on(level, line, exc_info)

    @property
    def level(self) -> int:
        """The least level that is written, as a number of `logging`."""
        has_handlers = self._logger.hasHandlers()
        return self._logger.getEffectiveLevel() if has_handlers else self._default_level

    def _emit(self, level: int, message: str, exc_info: Any) -> None:
        error = _error_of(exc_info)
        if not self._logger.hasHandlers():
            text = f"[{logging.getLevelName(level)}] [{self.name}]: {message}"
            _write_to_stderr(_with_traceback(text, exc_info))
        elif error is None:
            self._logger.log(level, "%s", message, stacklevel=4)
        else:
            self._logger.handle(self._record_of(level, message, error))

    def _record_of(self, level: int, message: str, error: BaseException) -> logging.LogRecord:
        """Return a record whose traceback is safe to show: formatters take the text it brings."""
        path, line, function = _find_caller()
        details = (type(error), error, error.__traceback__)
        record = self._logger.makeRecord(
            self._logger.name, level, path, line, "%s", (message,), details, function
        )
        record.exc_text = _traceback_of(error)
        return record

    def _is_enabled(self, level: int) -> bool:
        if self._logger.hasHandlers():
            return self._logger.isEnabledFor(level)
        return level >= self._default_level

    def _have_listen(self, listener: logging.Handler | None) -> None:
        self._listener = listener
        # The least where the application has set up nothing. Each record is compared with it.
        self._default_level = logging.INFO if listener is None else listener.level

    def _hand_on(self, level: int, message: Any, exc_info: Any) -> None:
        """Gives whoever listens a record, with the place where it was logged."""
        if self._listener is not None:
            text, (path, line, function) = _with_traceback(message, exc_info), _find_caller()
            self._listener.handle(
                logging.LogRecord(self.name, level, path, line, text, None, None, function)
            )

    def _first_time(self, level: int, message: str) -> bool:
        known = hash((level, message))
        with self._lock:
            if known in self._said:
                return False
            _make_room(self._said)
            self._said[known] = None
            return True


class _CustomLogger(RosbaseLogger):
    """A logger of the application's own, with whatever ours can do and it cannot."""

    def __init__(
        self, name: str, custom: Any, clock: Clock | None, listener: logging.Handler | None
    ) -> None:
        super().__init__(name, clock, listener)
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
                setattr(self, method, partial(self._say_its_way, method))

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
        message = _cleaned(message)
        if not once or self._first_time(level, message):
            exc_info = options.pop("exc_info", None)
            self._emit(level, message, exc_info, *more, **options)
            self._hand_on(level, _fill_in(message, more), exc_info)

    def _say_its_way(self, method: str, message: str, *more: Any, **options: Any) -> Any:
        """Writes as only the application's own logger can, at a level that it may be given."""
        message = _cleaned(message)
        answer = getattr(self._custom, method)(message, *more, **options)
        named = options.get("level", more[0] if more else "")
        level = logging.getLevelNamesMapping().get(str(named).upper(), logging.INFO)
        if method != "log_once" or self._first_time(level, message):
            self._hand_on(level, message, None)
        return answer

    def _hand_on(self, level: int, message: Any, exc_info: Any) -> None:
        # What the application's own logger writes is its affair; who listens has a level too.
        if level >= self._default_level:
            super()._hand_on(level, _cleaned(message), exc_info)

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
    name: str,
    custom: Callable[[str], Any] | None = None,
    clock: Clock | None = None,
    listener: logging.Handler | None = None,
) -> RosbaseLogger:
    """The logger of that name.

    Args:
        name: What its records are called.
        custom: A class of the application's own, which is called with the name.
        clock: What throttles.
        listener: A backend's handler, which is given what is logged, beside the console.
    """
    if custom is None:
        return RosbaseLogger(name, clock, listener)
    logger = custom(name)
    if not isinstance(logger, RosbaseLogger):
        return _CustomLogger(name, logger, clock, listener)
    # Made with the name alone, it cannot know which time counts here, and who listens.
    if clock is not None:
        logger._clock = clock
    logger._have_listen(listener)
    return logger


def _find_caller() -> tuple[str, int, str]:
    """File, line and function from which this module was called."""
    frame = sys._getframe()
    while frame.f_globals is globals() and frame.f_back is not None:
        frame = frame.f_back
    return frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name


def _fill_in(message: Any, values: tuple[Any, ...]) -> Any:
    """The text of a logger that takes values for it, as `logging` does; others take colours."""
    try:
        return message % values if values else message
    except (TypeError, ValueError):
        return message


def _cleaned(message: Any) -> Any:
    """The message as one line, if it is a text; a logger of the application's may take others."""
    return log_line(message) if isinstance(message, str) else message


def _error_of(exc_info: Any) -> BaseException | None:
    if isinstance(exc_info, BaseException):
        return exc_info
    return sys.exception() if exc_info else None


def _traceback_of(error: BaseException) -> str:
    return indented("".join(traceback.format_exception(error)).rstrip())


def _with_traceback(message: Any, exc_info: Any) -> Any:
    error = _error_of(exc_info)
    return message if error is None else f"{message}\n{_traceback_of(error)}"


def _make_room(known: dict[int, Any]) -> None:
    while len(known) >= _MANY_KEYS:
        del known[next(iter(known))]


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
