"""What a backend needs of a lifecycle node to offer it to the world."""

from collections.abc import Callable
from typing import Protocol

from rosbase.lifecycle.machine import TransitionEvent
from rosbase.lifecycle.table import CallbackReturn, State, Transition

__all__ = ["ManagedNode"]


class ManagedNode(Protocol):
    """A node with the managed lifecycle, for whoever asks from outside. `LifecycleNode` is one.

    Reading is allowed from any thread, also while a transition runs; a transition belongs on
    the thread that spins the backend.
    """

    def get_state(self) -> State:
        """Where the lifecycle is."""
        ...

    def get_available_transitions(self) -> tuple[Transition, ...]:
        """The transitions that start at the present state."""
        ...

    def describe_transition(self) -> str:
        """Say which transition runs and since when; an empty text if none does."""
        ...

    def request_transition(self, transition_id: int = 0, label: str = "") -> CallbackReturn:
        """Runs the transition of that label, or else of that id, with its callback.

        Raises:
            TransitionNotAvailableError: Not from this state, or another one is under way.
        """
        ...

    def add_transition_listener(self, listener: Callable[[TransitionEvent], object]) -> None:
        """Has `listener(event)` called after each step, on the thread that takes it.

        What the listener raises is reported and stops no transition.
        """
        ...
