"""The shutdown order: every step is attempted, even if steps before it failed."""

import threading
from collections.abc import Callable, Iterable
from typing import TypeAlias

from rosbase.errors import ServiceStoppedError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.stopping import StopSignals

__all__ = ["is_wish", "name_threads_left", "run_steps"]

Step: TypeAlias = tuple[str, Callable[[], object]]

# For threads that are about to end.
_THREADS_S = 0.2


def run_steps(
    steps: Iterable[Step],
    logger: RosbaseLogger,
    stop: StopSignals | None = None,
    end_run: Step | None = None,
) -> BaseException | None:
    """Run the named steps in order.

    Args:
        steps: Name and function of each step.
        logger: Logs each exception with its traceback.
        stop: The signals that may end a step that blocks.
        end_run: Ends the rest of the program. It comes first if the program was stopped from
            outside, because the other steps may wait for it; otherwise last.

    Returns:
        The first exception that one of them raised; none for a step that a signal ended.
    """
    first: BaseException | None = None
    steps = list(steps)
    if end_run is not None:
        is_first = stop is not None and stop.came_from_outside
        steps.insert(0 if is_first else len(steps), end_run)
    if stop is not None:
        stop.begin_clean_up()
    for name, step in steps:
        try:
            step()
        except BaseException as error:
            if is_wish(error, stop):
                logger.warning(f"shutdown: {name} was interrupted by a signal")
            else:
                logger.error(f"shutdown: {name} failed: {error}", exc_info=error)
                first = first or error
        if stop is not None:
            stop.begin_step()
    return first


def is_wish(error: BaseException, stop: StopSignals | None) -> bool:
    """Return whether an exception is a request to stop that ended blocking code."""
    if isinstance(error, ServiceStoppedError):
        return True
    return isinstance(error, KeyboardInterrupt) and stop is not None and stop.came_from_outside


def name_threads_left(known: Iterable[threading.Thread], logger: RosbaseLogger) -> None:
    """Log the threads that Python waits for before the process can end.

    Args:
        known: Threads that are not the application's, because they existed before it was built.
        logger: Logs a line for each.
    """
    ignored = {threading.current_thread(), threading.main_thread(), *known}
    for thread in threading.enumerate():
        if thread.daemon or thread in ignored:
            continue
        thread.join(_THREADS_S)
        if thread.is_alive():
            logger.warning(f"thread {thread.name!r} still runs; the process ends only after it")
