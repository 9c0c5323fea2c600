"""Measure a method or callback while the program runs: the time between calls, and of a call."""

import inspect
import weakref
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar, overload

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.node_connection import NodeConnection
from rosbase.logger import RosbaseLogger
from rosbase.utils.call_times import MANY_CALLS, CallTimes

__all__ = ["profile_latency"]

ArgumentsT = ParamSpec("ArgumentsT")
ResultT = TypeVar("ResultT")


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
        clock: The clock to measure by. By default the clock of the node, agent, handlers or manager
            that has the method, which is virtual in a test; else the machine's.
        logger: The logger of the report. By default the logger of the object that has the method,
            if it has one; else `latency`.

    Raises:
        TypeError: The function is async or a generator: its call does not run it.
    """
    if callable(cycle_threshold_ms):
        return profile_latency()(cycle_threshold_ms)

    def decorate(function: Callable[ArgumentsT, ResultT]) -> Callable[ArgumentsT, ResultT]:
        _check(function)
        if not debug:
            return function

        def start(owner: object) -> CallTimes:
            return CallTimes(
                function.__qualname__.rpartition("<locals>.")[2],
                clock or _clock_of(owner),
                logger or _logger_of(owner),
                cycle_threshold_ms,
                process_threshold_ms,
                log_interval_s,
            )

        return _profiled(function, start, has_age=check_capture_latency)

    return decorate


def _profiled(
    function: Callable[ArgumentsT, ResultT], start: Callable[[object], CallTimes], *, has_age: bool
) -> Callable[ArgumentsT, ResultT]:
    """Return the function with a measurement around it."""
    is_method = next(iter(inspect.signature(function).parameters), "") in ("self", "cls")
    found: dict[int, CallTimes] = {}
    watched: dict[int, Any] = {}
    nobody = id(None)

    def begin(arguments: tuple[object, ...]) -> CallTimes:
        owner = arguments[0] if is_method and arguments else None
        key = id(owner)
        found[key] = times = start(owner)
        if owner is not None:
            try:
                # Another object may get the same id later.
                watched[key] = weakref.ref(owner, lambda _: (found.pop(key), watched.pop(key)))
            except TypeError:
                # It cannot be watched, as one with slots alone.
                pass
        return times

    @wraps(function)
    def profiled(*args: ArgumentsT.args, **kwargs: ArgumentsT.kwargs) -> ResultT:
        # In a loop that sleeps, the processor is cold, and each line here costs ten times as much.
        times = found.get(id(args[0]) if is_method and args else nobody) or begin(args)
        start_ns = times.read_ns()
        try:
            return function(*args, **kwargs)
        finally:
            end_ns = times.read_ns()
            times.calls += (start_ns, end_ns)
            if has_age:
                times.add_age(args, end_ns - start_ns)
            if (
                start_ns > times.late_ns
                or end_ns - start_ns > times.long_ns
                or end_ns >= times.due_ns
                or len(times.calls) > MANY_CALLS
            ):
                times.look_at(start_ns, end_ns)
            times.late_ns = start_ns + times.cycle_ns

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
