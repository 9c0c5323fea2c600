"""Questions about lifecycle nodes, and their transitions."""

from __future__ import annotations

from rosbase.control.gathering import ask_one
from rosbase.control.questions.base import Questions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.shapes import LifecycleState, TransitionInfo, TransitionResult

__all__ = ["LifecycleQuestions"]


class LifecycleQuestions(Questions):
    """Questions about lifecycle nodes."""

    def lifecycle_states(self) -> list[LifecycleState]:
        """Return the states of all lifecycle nodes, by name."""
        found: list[Any] = [
            {**node, "pid": pid}
            for pid, answer in self._gather("lifecycle.list")
            for node in answer["nodes"]
        ]
        return sorted(found, key=lambda node: (node["name"], node["pid"]))

    def lifecycle_state(self, node: str) -> LifecycleState:
        """Return the state of a node.

        Raises:
            ControlError: No program has such a lifecycle node, or several have.
        """
        states = self.lifecycle_states()
        full, pid = self._among(node, states)
        return next(s for s in states if (s["name"], s["pid"]) == (full, pid))

    def transitions(self, node: str) -> list[TransitionInfo]:
        """Return the transitions that a node offers in its state.

        Raises:
            ControlError: As from `lifecycle_state`.
        """
        full, pid = self._among(node, self.lifecycle_states())
        found: list[TransitionInfo] = ask_one(pid, "lifecycle.get", {"node": full})[0]["available"]
        return found

    def change_state(
        self, node: str, transition: str | int, *, timeout_s: float = 30.0
    ) -> TransitionResult:
        """Run a transition; return what became of it.

        Args:
            node: Name of the node.
            transition: Label or id of the transition.
            timeout_s: How long to wait for its end, in seconds.

        Raises:
            ControlError: As from `lifecycle_state`; of kind `refused` if the node does not offer
                the transition now.
        """
        full, pid = self._among(node, self.lifecycle_states())
        arguments = {
            "node": full, "transition": transition, "timeout_ns": int(timeout_s * 1e9)
        }  # fmt: skip
        result: TransitionResult = ask_one(pid, "lifecycle.set", arguments, wait_s=timeout_s + 1.0)[
            0
        ]
        return result

    def _among(self, name: str, states: list[LifecycleState]) -> tuple[str, int]:
        owners: dict[str, list[int]] = {}
        for state in states:
            owners.setdefault(state["name"], []).append(state["pid"])
        return self._one("lifecycle node", name, owners)
