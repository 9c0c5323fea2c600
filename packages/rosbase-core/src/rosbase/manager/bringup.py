"""Lifecycle nodes under a manager: up in order of registration, down in reverse."""

from collections.abc import Callable, Iterable, Sequence

from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import CallbackReturn, State
from rosbase.lifecycle_node import LifecycleNode

__all__ = ["bring_up", "take_down"]


def bring_up(nodes: Sequence[LifecycleNode], stopping: Callable[[], bool]) -> bool:
    """Brings each node as far as its `autostart` says.

    If one does not get there, those before it are taken back to unconfigured, in reverse.

    Returns:
        Whether all of them got there.
    """
    for index, node in enumerate(nodes):
        if stopping():
            return False
        if not _reach(node):
            for done in reversed(nodes[:index]):
                _step_down(done, finalize=False)
            return False
    return True


def take_down(nodes: Iterable[LifecycleNode]) -> None:
    """Deactivates, cleans up and shuts down each node, the last one first."""
    for node in reversed(list(nodes)):
        _step_down(node, finalize=True)


def _reach(node: LifecycleNode) -> bool:
    labels = {"none": (), "configure": ("configure",), "activate": ("configure", "activate")}
    return all(
        node.request_transition(label=label) is CallbackReturn.SUCCESS
        for label in labels[node.autostart]
    )


def _step_down(node: LifecycleNode, *, finalize: bool) -> None:
    try:
        for state, label in ((State.ACTIVE, "deactivate"), (State.INACTIVE, "cleanup")):
            if node.get_state() is state:
                node.request_transition(label=label)
        if finalize and node.get_state() is not State.FINALIZED:
            node.request_transition(label="shutdown")
    except TransitionNotAvailableError as error:
        node.logger.error(f"a lifecycle node could not be taken down: {error}")
