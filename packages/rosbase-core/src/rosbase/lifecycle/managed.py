"""The interface of a lifecycle node that a backend offers to other programs."""

from collections.abc import Callable
from typing import Protocol

from rosbase.lifecycle.machine import TransitionEvent
from rosbase.lifecycle.table import CallbackReturn, State, Transition

__all__ = ["ManagedNode"]


class ManagedNode(Protocol):
    """Interface of a node with the managed lifecycle. `LifecycleNode` implements it.

    You may read from any thread, also while a transition runs. Run transitions on the thread
    that spins the backend.
    """

    def get_state(self) -> State:
        """Return the current state of the lifecycle."""
        ...

    def get_available_transitions(self) -> tuple[Transition, ...]:
        """Return the transitions that start at the current state."""
        ...

    def describe_transition(self) -> str:
        """Say which transition runs and since when; an empty text if none does."""
        ...

    def request_transition(self, transition_id: int = 0, label: str = "") -> CallbackReturn:
        """Run the transition of that label, or else of that id, with its callback.

        Raises:
            TransitionNotAvailableError: It does not start at this state, or another one is
                running.
        """
        ...

    def add_transition_listener(self, listener: Callable[[TransitionEvent], object]) -> None:
        """Call `listener(event)` after each step, on the thread that takes it.

        Exceptions of the listener are reported and stop no transition.
        """
        ...
