"""The lifecycle as a state machine that follows the table. It calls nothing and awaits nothing.

The caller asks for a transition, runs the callback that the new state names, and tells the machine
the result of the callback:

    event = machine.request(label="configure")     # unconfigured -> configuring
    event = machine.finish(CallbackReturn.ERROR)   # configuring -> errorprocessing
    event = machine.finish(CallbackReturn.SUCCESS) # errorprocessing -> unconfigured
"""

from attrs import frozen

from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle.table import (
    RAISE_ERROR_LABEL,
    CallbackReturn,
    State,
    Transition,
    starting_at,
)

__all__ = ["Machine", "TransitionEvent"]


@frozen
class TransitionEvent:
    """One step of the machine (lifecycle_msgs/TransitionEvent without its time)."""

    transition: Transition

    @property
    def start(self) -> State:
        """State that was left."""
        return self.transition.start

    @property
    def goal(self) -> State:
        """State that was reached."""
        return self.transition.goal


class Machine:
    """The lifecycle state of one node. Not thread-safe: one driver at a time."""

    __slots__ = ("_previous", "_state")

    def __init__(self) -> None:
        self._state = State.UNCONFIGURED
        self._previous = State.UNCONFIGURED

    @property
    def state(self) -> State:
        """Current state of the machine."""
        return self._state

    @property
    def previous_state(self) -> State:
        """Primary state before the current transition. Callbacks receive it."""
        return self._previous

    def available_transitions(self) -> tuple[Transition, ...]:
        """Transitions that start at the current state."""
        return starting_at(self._state)

    def request(self, transition_id: int = 0, label: str = "") -> TransitionEvent:
        """Leave a primary state by a public transition.

        Args:
            transition_id: Its id; used only if there is no label.
            label: Its label, looked up among the transitions of the current state, so that
                `shutdown` is 5, 6 or 7. A label takes precedence over an id, as in rcl.

        Raises:
            TransitionNotAvailableError: No transition of that name or id starts here. The state
                has not changed.
        """
        for transition in self.available_transitions():
            wanted = transition.label == label if label else transition.id == transition_id
            if wanted and transition.is_public:
                self._previous = self._state
                return self._take(transition)
        asked = f"'{label}'" if label else f"with id {transition_id}"
        raise TransitionNotAvailableError(
            f"no transition {asked} is available in state {self._state.label}"
        )

    def finish(self, answer: CallbackReturn) -> TransitionEvent:
        """Leave a transition state with the result of its callback.

        Raises:
            TransitionNotAvailableError: No transition is running.
        """
        for transition in self.available_transitions():
            if transition.label == answer.label:
                return self._take(transition)
        raise TransitionNotAvailableError(f"no callback is under way in state {self._state.label}")

    def raise_error(self) -> TransitionEvent:
        """Go from a primary state to errorprocessing, for a fault outside of any transition.

        Raises:
            TransitionNotAvailableError: A transition is running, or the node is finalized.
        """
        if not self._state.is_primary or self._state is State.FINALIZED:
            raise TransitionNotAvailableError(
                f"no error can be raised in state {self._state.label}"
            )
        self._previous = self._state
        return self._take(Transition(0, RAISE_ERROR_LABEL, self._state, State.ERRORPROCESSING))

    def _take(self, transition: Transition) -> TransitionEvent:
        self._state = transition.goal
        return TransitionEvent(transition)
