"""Bring lifecycle nodes up in order of registration, and down in reverse."""

from collections.abc import Callable, Iterable, Sequence

from rosbase.logger import RosbaseLogger
from rosbase.roles.lifecycle_node import LifecycleNode

__all__ = ["bring_up", "take_down"]


def bring_up(
    nodes: Sequence[LifecycleNode], stopping: Callable[[], object], logger: RosbaseLogger
) -> bool:
    """Bring each node as far as its `autostart` says.

    If a node does not get there, it and the nodes before it return to unconfigured, in reverse
    order.

    Returns:
        Whether all of them got there.
    """
    for index, node in enumerate(nodes):
        if stopping():
            return False
        if not node.bring_up(stopping):
            if stopping():
                # What has come up is taken down in the clean-up, which no signal interrupts.
                return False
            _name_the_rest(nodes, index, logger)
            _take_down(nodes[: index + 1], logger, finalize=False)
            return False
    return True


def _name_the_rest(nodes: Sequence[LifecycleNode], failed: int, logger: RosbaseLogger) -> None:
    def names(some: Iterable[LifecycleNode]) -> str:
        return ", ".join(node._label for node in some)

    if len(nodes) == 1:
        # Its own failure has been logged.
        return
    text = f"{nodes[failed]._label} was not brought up"
    if failed:
        text += f"; taken down again: {names(reversed(nodes[:failed]))}"
    if nodes[failed + 1 :]:
        text += f"; not tried: {names(nodes[failed + 1 :])}"
    logger.error(text)


def take_down(nodes: Iterable[LifecycleNode], logger: RosbaseLogger) -> None:
    """Deactivate, clean up and shut down each node, the last one first.

    Every node is attempted; the first exception is raised at the end.
    """
    _take_down(nodes, logger, finalize=True)


def _take_down(nodes: Iterable[LifecycleNode], logger: RosbaseLogger, *, finalize: bool) -> None:
    failure: BaseException | None = None
    for node in reversed(list(nodes)):
        try:
            node.take_down(finalize=finalize)
        except BaseException as error:
            # Not with a logger of the node, which may be what is broken.
            logger.error(f"{node._label} could not be taken down: {error!r}")
            failure = failure or error
    if failure is not None:
        raise failure
