"""The shutdown order: every step is attempted, whatever the ones before it did."""

import threading
from collections.abc import Callable, Iterable

from rosbase.logger import RosbaseLogger
from rosbase.runtime.stopping import StopSignals

__all__ = ["name_threads_left", "run_steps"]

# For threads that are about to end.
_THREADS_S = 0.2


def run_steps(
    steps: Iterable[tuple[str, Callable[[], object]]],
    logger: RosbaseLogger,
    stop: StopSignals | None = None,
) -> BaseException | None:
    """Run the named steps in order.

    Args:
        steps: What each is called, and what it does.
        logger: Logs each exception with its traceback.
        stop: The signals that may end a step that blocks.

    Returns:
        The first exception that one of them raised; none for a step that a signal ended.
    """
    first: BaseException | None = None
    if stop is not None:
        stop.begin_clean_up()
    for name, step in steps:
        try:
            step()
        except BaseException as error:
            if stop is not None and stop.was_asked and isinstance(error, KeyboardInterrupt):
                logger.warning(f"shutdown: {name} was interrupted by a signal")
            else:
                logger.error(f"shutdown: {name} failed: {error}", exc_info=error)
                first = first or error
        if stop is not None:
            stop.begin_step()
    return first


def name_threads_left(known: Iterable[threading.Thread], logger: RosbaseLogger) -> None:
    """Log the threads for which Python will wait before the process can end.

    Args:
        known: Threads that are not the application's: those from before it was built.
        logger: Logs a line for each.
    """
    ignored = {threading.current_thread(), threading.main_thread(), *known}
    for thread in threading.enumerate():
        if thread.daemon or thread in ignored:
            continue
        thread.join(_THREADS_S)
        if thread.is_alive():
            logger.warning(f"thread {thread.name!r} still runs; the process ends only after it")
