"""The shutdown order: every step is attempted, whatever the ones before it did."""

from collections.abc import Callable, Iterable

from rosbase.logger import RosbaseLogger

__all__ = ["run_steps"]


def run_steps(
    steps: Iterable[tuple[str, Callable[[], object]]], logger: RosbaseLogger
) -> BaseException | None:
    """Runs the named steps in order.

    Returns:
        The first exception that one of them raised. Each is logged with its traceback.
    """
    first: BaseException | None = None
    for name, step in steps:
        try:
            step()
        except BaseException as error:
            logger.error(f"shutdown: {name} failed: {error}", exc_info=error)
            first = first or error
    return first
