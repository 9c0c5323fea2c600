"""Where transitions of other threads come into a recorded program."""

from collections.abc import Callable
from typing import Any, Protocol

from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import NUMBERED, Kind
from rosbase.entries.outcomes import error_from_json, error_to_json
from rosbase.entries.payloads import Json, from_json, to_json
from rosbase.entries.script import Entry
from rosbase.lifecycle import CallbackReturn

__all__ = ["TransitionEntrance"]


class _Driven(Protocol):
    """The transitions of a node."""

    def request(self, transition_id: int, label: str) -> CallbackReturn:
        """Run the transition of that label, or else of that id."""
        ...

    def raise_error(self, error: BaseException) -> CallbackReturn:
        """Run `on_error`."""
        ...


class TransitionEntrance:
    """The way into the program for the transitions of one node.

    A thread that asks for one waits for the turn, because it wants the result.
    """

    def __init__(self, conductor: Conductor, text: str, transitions: _Driven) -> None:
        """Number the node.

        Args:
            conductor: The conductor of the program.
            text: The class of the node.
            transitions: Its transitions.
        """
        self._conductor = conductor
        self._transitions = transitions
        self._number = conductor.number(NUMBERED[Kind.CHANGE_STATE], text, self._replay)

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program, so that nothing has to come in."""
        return self._conductor.is_inside

    def request(
        self, transition_id: int, label: str, run: Callable[[], CallbackReturn]
    ) -> CallbackReturn:
        """Run a transition as an entry, and return its result."""
        return self._enter({"id": transition_id, "label": label}, run)

    def raise_error(
        self, error: BaseException, run: Callable[[], CallbackReturn]
    ) -> CallbackReturn:
        """Run `on_error` as an entry, and return its result."""
        return self._enter({"error": error_to_json(error)}, run)

    def let_others(self, wait: Callable[[], bool]) -> bool:
        """Wait for a thread that needs the turn to end its transition.

        It has spoiled the recording, because it waited within an entry.
        """
        results: list[bool] = []
        self._conductor.aside(lambda: results.append(wait()))
        return all(results)

    def _enter(self, asked: Json, run: Callable[[], CallbackReturn]) -> CallbackReturn:
        return self._conductor.enter(Kind.CHANGE_STATE, (self._number,), to_json(asked), run)

    def _replay(self, entry: Entry) -> CallbackReturn:
        asked: Any = from_json(entry.payload)
        if "error" in asked:
            return self._transitions.raise_error(error_from_json(asked["error"]))
        return self._transitions.request(asked["id"], asked["label"])
