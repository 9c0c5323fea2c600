"""Measure a method or callback while the program runs: the time between calls, and of a call."""

import inspect
import weakref
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar, overload

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.node_connection import NodeConnection
from rosbase.logger import RosbaseLogger
from rosbase.utils.durations import Durations

__all__ = ["profile_latency"]

ArgumentsT = ParamSpec("ArgumentsT")
ResultT = TypeVar("ResultT")

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1e6


@overload
def profile_latency(
    cycle_threshold_ms: Callable[ArgumentsT, ResultT], /
) -> Callable[ArgumentsT, ResultT]: ...
@overload
def profile_latency(
    cycle_threshold_ms: float = 50,
    process_threshold_ms: float = 20,
    log_interval_s: float = 5,
    debug: bool = True,
    check_capture_latency: bool = False,
    *,
    clock: Clock | None = None,
    logger: RosbaseLogger | None = None,
) -> Callable[[Callable[ArgumentsT, ResultT]], Callable[ArgumentsT, ResultT]]: ...
def profile_latency(
    cycle_threshold_ms: Any = 50,
    process_threshold_ms: float = 20,
    log_interval_s: float = 5,
    debug: bool = True,
    check_capture_latency: bool = False,
    *,
    clock: Clock | None = None,
    logger: RosbaseLogger | None = None,
) -> Any:
    """Decorate a method or callback: log the time between its calls, and the time of each call.

    Each interval, one line has the mean, the percentiles and the maximum in milliseconds. A warning
    names the first call of an interval that is beyond a threshold. A method is measured for each
    object on its own.

    Args:
        cycle_threshold_ms: Longest time from one call to the next without a warning.
        process_threshold_ms: Longest time of a call without a warning.
        log_interval_s: Seconds between two reports, at the end of the first call after them.
        debug: With False, the function is returned as it is, and costs nothing.
        check_capture_latency: Whether to measure also the age of the message when the call begins:
            of the first argument with a `header.stamp`. The dates of the sender and of this machine
            must agree.
        clock: The clock to measure by. By default that of the node, agent, handlers or manager that
            has the method, which is virtual in a test; else that of the machine.
        logger: The logger of the report. By default that of the object that has the method, if it
            has one; else `latency`.

    Raises:
        TypeError: The function is async or a generator: its call does not run it.
    """
    if callable(cycle_threshold_ms):
        return profile_latency()(cycle_threshold_ms)

    def decorate(function: Callable[ArgumentsT, ResultT]) -> Callable[ArgumentsT, ResultT]:
        _check(function)
        if not debug:
            return function

        def start(owner: object) -> _Latency:
            return _Latency(
                function.__qualname__.rpartition("<locals>.")[2],
                clock or _clock_of(owner),
                logger or _logger_of(owner),
                Durations("cycle", cycle_threshold_ms),
                Durations("process", process_threshold_ms),
                Durations("age of the stamp") if check_capture_latency else None,
                int(log_interval_s * _NS_PER_S),
            )

        return _profiled(function, start)

    return decorate


class _Latency:
    """Durations of one function, of one object if it is a method."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        logger: RosbaseLogger,
        cycle: Durations,
        process: Durations,
        age: Durations | None,
        interval_ns: int,
    ) -> None:
        self.read_ns = clock.monotonic_ns
        self._name, self._clock, self._logger = name, clock, logger
        self._cycle, self._process, self._age = cycle, process, age
        self._interval_ns = interval_ns
        self._last_ns: int | None = None
        self._begun_ns = self.read_ns()

    def add(self, start_ns: int, arguments: tuple[object, ...]) -> None:
        """Add a call that has just ended."""
        end_ns = self.read_ns()
        last_ns, self._last_ns = self._last_ns, start_ns
        if last_ns is not None and self._cycle.add(start_ns - last_ns):
            self._warn(self._cycle, start_ns - last_ns)
        if self._process.add(end_ns - start_ns):
            self._warn(self._process, end_ns - start_ns)
        if self._age is not None:
            stamp_ns = _stamp_in(arguments)
            if stamp_ns:
                self._age.add(self._clock.now_ns() - (end_ns - start_ns) - stamp_ns)
        if end_ns - self._begun_ns >= self._interval_ns:
            self._report(end_ns)

    def _warn(self, durations: Durations, duration_ns: int) -> None:
        self._logger.warning(
            f"{self._name}: {durations.name} took {duration_ns / _NS_PER_MS:.3f} ms,"
            f" more than {durations.threshold_ms:g}"
        )

    def _report(self, now_ns: int) -> None:
        kinds = [kind for kind in (self._cycle, self._process, self._age) if kind is not None]
        parts = "; ".join(filter(None, (kind.report() for kind in kinds)))
        self._logger.info(f"{self._name}: {parts}")
        for kind in kinds:
            kind.clear()
        self._begun_ns = now_ns


def _profiled(
    function: Callable[ArgumentsT, ResultT], start: Callable[[object], _Latency]
) -> Callable[ArgumentsT, ResultT]:
    """Return the function with a measurement around it."""
    first = next(iter(inspect.signature(function).parameters), "")
    is_method = first in ("self", "cls")
    found: dict[int, _Latency] = {}

    def begin(arguments: tuple[object, ...]) -> _Latency:
        owner = arguments[0] if is_method and arguments else None
        key = id(owner)
        found[key] = latency = start(owner)
        if owner is not None:
            try:
                # Another object may get the same id later.
                watched[key] = weakref.ref(owner, lambda _: (found.pop(key), watched.pop(key)))
            except TypeError:
                pass
        return latency

    watched: dict[int, Any] = {}
    nobody = id(None)

    @wraps(function)
    def profiled(*args: ArgumentsT.args, **kwargs: ArgumentsT.kwargs) -> ResultT:
        latency = found.get(id(args[0]) if is_method and args else nobody) or begin(args)
        start_ns = latency.read_ns()
        try:
            return function(*args, **kwargs)
        finally:
            latency.add(start_ns, args)

    return profiled


def _check(function: Callable[..., object]) -> None:
    is_late = inspect.iscoroutinefunction(function) or inspect.isgeneratorfunction(function)
    if is_late or inspect.isasyncgenfunction(function):
        raise TypeError(
            f"profile_latency cannot measure {function.__qualname__}: a call of it only"
            " makes a coroutine or a generator"
        )


def _clock_of(owner: object) -> Clock:
    """Return the clock of a component, or the machine's."""
    # Not by `getattr`: a program's own `__getattr__` may answer anything.
    attributes = getattr(owner, "__dict__", {})
    manager = attributes.get("manager")
    for connection in (
        attributes.get("_connection"),
        attributes.get("backend"),
        getattr(manager, "backend", None),
    ):
        if isinstance(connection, NodeConnection):
            return connection.clock
    return SystemClock()


def _logger_of(owner: object) -> RosbaseLogger:
    logger = getattr(owner, "__dict__", {}).get("logger")
    return logger if isinstance(logger, RosbaseLogger) else RosbaseLogger("latency")


def _stamp_in(arguments: tuple[object, ...]) -> int:
    """Return the stamp of the first message in nanoseconds; 0 if there is none."""
    for argument in arguments:
        stamp = getattr(getattr(argument, "header", None), "stamp", None)
        if stamp is not None and hasattr(stamp, "nanosec"):
            return int(stamp.sec) * _NS_PER_S + int(stamp.nanosec)
    return 0
