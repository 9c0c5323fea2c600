"""The logger of the four roles: based on the standard library's, with the methods of rclpy."""

import copy
import logging
import math
import threading
from types import FrameType
from typing import TYPE_CHECKING

from rosbase.clock import Clock, SystemClock
from rosbase.logger.call_sites import calling_frame, site_of
from rosbase.logger.console import current_console
from rosbase.logger.dates import date_at, is_dropped, set_date
from rosbase.logger.destination import survey
from rosbase.logger.filters import FILTERS, Filters, LogOptions, make_room
from rosbase.logger.levels import level_number, message_level
from rosbase.logger.log_file import current_log_file
from rosbase.logger.observer import observers
from rosbase.logger.record_text import error_of, fill_in, stack_of, traceback_of, whole_text
from rosbase.text.printable import log_line

if TYPE_CHECKING:
    # `typing` has it from Python 3.11 on.
    from typing_extensions import Unpack

    from rosbase.logger.rotating_file import LogFile

__all__ = ["RosbaseLogger"]

_NS_PER_S = 1_000_000_000
# From so many on, the oldest are forgotten. Their hashes are kept, for a key may be a long text.
_MANY_KEYS = 1000


class RosbaseLogger:
    """Writes records to `logging.getLogger("rosbase.<name>")`.

    An application that sets up handlers decides about them, their levels and formats, as
    everywhere in Python. Otherwise, records of INFO and above go to stderr in the format of
    ROS 2.

    Each message is one line of printable characters: line ends and control characters are
    written as escapes, and a traceback is indented below the line.

    Every level takes `message, *values` as in `logging`, and the keyword arguments of
    `LogOptions`. A backend may listen, with its own handler.
    """

    _file: "LogFile | None" = None
    """A log file of its own, besides the program's."""

    def __init__(
        self,
        name: str,
        clock: Clock | None = None,
        listener: logging.Handler | None = None,
        *,
        has_console: bool = True,
    ) -> None:
        """Make the logger.

        Args:
            name: Name of its records.
            clock: Clock for throttling.
            listener: A backend's handler, which gets the records beside the console. Its level
                counts where none is set in `logging`.
            has_console: Whether the console gets records too.
        """
        self.name = name
        self._logger = logging.getLogger(f"rosbase.{name}")
        self._clock = clock or SystemClock()
        self._have_listen(listener, has_console=has_console)
        self._filters = Filters()
        self._said: dict[int, None] = {}
        self._next_ns: dict[int, float] = {}
        self._lock = threading.Lock()

    def debug(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at DEBUG."""
        self._log(logging.DEBUG, message, values, options)

    def info(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at INFO."""
        self._log(logging.INFO, message, values, options)

    def warning(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at WARN: something is wrong, but work continues."""
        self._log(logging.WARNING, message, values, options)

    def warn(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at WARN, as `warning`."""
        self._log(logging.WARNING, message, values, options)

    def error(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at ERROR: some work has stopped."""
        self._log(logging.ERROR, message, values, options)

    def exception(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at ERROR, with the traceback of the exception that is being handled."""
        self._log(logging.ERROR, message, values, {"exc_info": True, **options})

    def critical(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at FATAL: all work has stopped."""
        self._log(logging.CRITICAL, message, values, options)

    def fatal(self, message: object, *values: object, **options: "Unpack[LogOptions]") -> None:
        """Log at FATAL, as `critical`."""
        self._log(logging.CRITICAL, message, values, options)

    def important(self, message: str, level: str | int = "INFO") -> None:
        """Log a message that should stand out: between asterisks, and bold where there are colours.

        Raises:
            ValueError: There is no such level.
        """
        options: LogOptions = {"extra": {"is_important": True}}
        self._log(message_level(level), f"*** {message} ***", (), options)

    def log_once(self, message: str, level: str | int = "INFO") -> None:
        """Log a message the first time only, from any place.

        Raises:
            ValueError: There is no such level.
        """
        number = message_level(level)
        if self.is_enabled_for(number) and self._first_time(number, message):
            self._log(number, message)

    def log_throttle(self, message: str, seconds: float, level: str | int = "INFO") -> None:
        """Log the same message at the same level at most once in a number of seconds.

        It counts from any place. `math.inf` seconds are once for all. A message of a disabled
        level does not count.

        Raises:
            TypeError: `seconds` is no number.
            ValueError: There is no such level, or `seconds` is NaN.
        """
        number, pause_ns = message_level(level), _nanoseconds(seconds)
        if self.is_enabled_for(number) and self._is_due((number, message), pause_ns):
            self._log(number, message)

    def due(self, key: str, seconds: float) -> bool:
        """Return whether `key` may be logged again, at most once in `seconds`.

        Use it for messages that change with every call, and should be throttled together.

        Raises:
            TypeError: `seconds` is no number.
            ValueError: `seconds` is NaN.
        """
        return self._is_due(key, _nanoseconds(seconds))

    def _is_due(self, key: object, pause_ns: float) -> bool:
        now_ns, known = self._clock.monotonic_ns(), hash(key)
        with self._lock:
            if now_ns < self._next_ns.get(known, now_ns):
                return False
            if len(self._next_ns) >= _MANY_KEYS:
                self._next_ns = {k: due for k, due in self._next_ns.items() if due > now_ns}
            make_room(self._next_ns)
            self._next_ns[known] = now_ns + pause_ns
            return True

    def reset(self) -> None:
        """Forget which calls were logged once, skipped or throttled."""
        self._filters.reset()
        with self._lock:
            self._said.clear()
            self._next_ns.clear()

    def get_child(self, suffix: str) -> "RosbaseLogger":
        """Return a logger below this one, named `<name>.<suffix>`, with its level and listener."""
        name = f"{self.name}.{suffix}"
        child = RosbaseLogger(name, self._clock, self._listener, has_console=self._has_console)
        child._file = self._file
        return child

    def twin(self, clock: Clock) -> "RosbaseLogger":
        """Return a logger of the same name and destinations, with throttles of its own.

        Args:
            clock: Clock for throttling.
        """
        twin = copy.copy(self)
        twin._clock, twin._lock = clock, threading.Lock()
        twin._filters, twin._said, twin._next_ns = Filters(), {}, {}
        return twin

    def set_level(self, level: str | int) -> None:
        """Set the minimum level that is logged; 0 resets it.

        Raises:
            ValueError: No level has that name.
        """
        self._logger.setLevel(level_number(level))

    def get_effective_level(self) -> int:
        """Return the minimum level that is logged, as a number of `logging`."""
        is_applications, chosen = survey(self._logger)
        if is_applications:
            return self._logger.getEffectiveLevel()
        return chosen or self._default_level

    def is_enabled_for(self, level: str | int) -> bool:
        """Return whether a record of this level would be logged."""
        return self._way(level_number(level)) is not None

    @property
    def level(self) -> int:
        """Minimum level that is logged, as a number of `logging`."""
        return self.get_effective_level()

    def _way(self, level: int) -> bool | None:
        """Return whether the application's handlers get a record of this level.

        None means that nobody does.
        """
        logger = self._logger
        if level < self._default_level and not logger.isEnabledFor(level) and not logger.disabled:
            # Nowhere either way. Python remembers the answer, so this costs next to nothing.
            return None
        is_applications, chosen = survey(logger)
        if is_applications:
            # `dictConfig` and `fileConfig` disable, by default, every logger that exists already.
            logger.disabled = False
            is_enabled = logger.isEnabledFor(level)
        else:
            least = max(chosen or self._default_level, logger.manager.disable + 1)
            is_enabled = level >= least
        return is_applications if is_enabled else None

    def _log(
        self,
        level: int,
        message: object,
        values: tuple[object, ...] = (),
        options: LogOptions | None = None,
    ) -> None:
        way = self._way(level)
        if way is None or is_dropped():
            return
        options = options or {}
        frame = calling_frame(options.get("stacklevel", 1))
        if options and not self._passes(level, options, frame):
            return
        record = self._record_of(level, log_line(fill_in(message, values)), frame, options)
        self._emit(record, is_applications=way)
        self._hand_on(record)

    def _pass_on(self, level: int, message: str) -> None:
        """Log a message at any level: the logger of another process has decided to log it."""
        logger = self._logger
        if level <= logger.manager.disable:
            return
        is_applications, _ = survey(logger)
        if is_applications:
            logger.disabled = False
        record = self._record_of(level, log_line(message), calling_frame(), {})
        self._emit(record, is_applications=is_applications)
        self._hand_on(record)

    def _say_again(self, date_ns: int, level: int, text: str, place: tuple[str, int, str]) -> None:
        """Log what a recording has, with its date: a line, perhaps with lines below it.

        The record has the attribute `is_said_again`, so that it is not taken for the program's own.
        """
        (line, _, below), (file, number, function) = text.partition("\n"), place
        logger = self._logger
        record = logger.makeRecord(logger.name, level, file, number, line, (), None, function)
        record.exc_text = below or None
        record.is_said_again = True
        date_at(record, date_ns)
        self._emit(record, is_applications=survey(logger)[0])
        self._hand_on(record)

    def _passes(self, level: int, options: LogOptions, frame: FrameType) -> bool:
        if unknown := options.keys() - LogOptions.__annotations__.keys():
            raise TypeError(f"a logger does not take {', '.join(sorted(unknown))}")
        is_filtered = not FILTERS.isdisjoint(options)
        return not is_filtered or self._filters.pass_on(site_of(frame), level, options, self._clock)

    def _emit(self, record: logging.LogRecord, *, is_applications: bool) -> None:
        """Pass a record to the application's handlers, or to the console."""
        if is_applications:
            self._logger.handle(record)
        elif self._has_console:
            current_console().handle(record)

    def _record_of(
        self, level: int, line: str, frame: FrameType, options: LogOptions
    ) -> logging.LogRecord:
        """Return a record whose traceback is safe to show: formatters use its prepared text."""
        error, code = error_of(options.get("exc_info")), frame.f_code
        record = self._logger.makeRecord(
            self._logger.name,
            level,
            code.co_filename,
            frame.f_lineno,
            line,
            (),
            None if error is None else (type(error), error, error.__traceback__),
            code.co_name,
            options.get("extra"),
            stack_of(frame) if options.get("stack_info") else None,
        )
        record.exc_text = None if error is None else traceback_of(error)
        set_date(record)
        return record

    def _have_listen(self, listener: logging.Handler | None, *, has_console: bool) -> None:
        self._listener, self._has_console = listener, has_console
        # The least where none is set in `logging`. Each record is compared with it.
        self._default_level = logging.INFO if listener is None else listener.level

    def _hand_on(self, record: logging.LogRecord) -> None:
        """Pass a record to observers and log files, and its whole text to the listener."""
        for observer in observers.copy():
            observer(record)
        files = self._file, current_log_file()
        for file in files[files[0] is files[1] :]:
            if file is not None:
                self._write_to(file, record)
        if self._listener is None:
            return
        heard = copy.copy(record)
        heard.name, heard.msg = self.name, whole_text(record)
        heard.exc_info = heard.exc_text = heard.stack_info = None
        self._listener.handle(heard)

    def _write_to(self, file: "LogFile", record: logging.LogRecord) -> None:
        file.handle(record)
        if fault := file.take_fault():
            self.warning(fault)

    def _first_time(self, level: int, message: str) -> bool:
        known = hash((level, message))
        with self._lock:
            if known in self._said:
                return False
            make_room(self._said)
            self._said[known] = None
            return True


def _nanoseconds(seconds: float) -> float:
    if isinstance(seconds, (str, bytes)):
        raise TypeError(f"seconds is a number, not {seconds!r}")
    pause_s = float(seconds)
    if math.isnan(pause_s):
        raise ValueError("seconds is a number, not NaN")
    return int(pause_s * _NS_PER_S) if math.isfinite(pause_s) else pause_s
