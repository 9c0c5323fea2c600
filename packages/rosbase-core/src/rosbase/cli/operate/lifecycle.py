"""`rosbase lifecycle nodes`, `list`, `get` and `set`."""

from __future__ import annotations

import sys

from rosbase.control.questions.lifecycle import LifecycleQuestions
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["change_state", "show_nodes", "show_state", "show_transitions"]

_MOST_DIGITS = 9


def show_nodes(given: Any) -> None:
    """Print the names of the lifecycle nodes, one a line."""
    states = LifecycleQuestions(given.program).lifecycle_states()
    if given.count_nodes:
        print(len(states))
        return
    for state in states:
        print(state["name"])


def show_transitions(given: Any) -> None:
    """Print what a node offers in its state, as `ros2 lifecycle list` does."""
    for one in LifecycleQuestions(given.program).transitions(given.node):
        print(f"- {one['label']} [{one['id']}]\n\tStart: {one['start']}\n\tGoal: {one['goal']}")


def show_state(given: Any) -> None:
    """Print the state of a node, or of all, as `ros2 lifecycle get` does."""
    questions = LifecycleQuestions(given.program)
    if given.node is not None:
        state = questions.lifecycle_state(given.node)
        print(f"{state['state']} [{state['id']}]")
        return
    for state in questions.lifecycle_states():
        print(f"{state['name']}: {state['state']} [{state['id']}]")


def change_state(given: Any) -> int:
    """Run a transition; the status says whether it succeeded."""
    questions = LifecycleQuestions(given.program)
    wanted = given.transition
    try:
        # Ids are of one byte, and Python reads no number of thousands of digits.
        is_id = wanted.isdecimal() and len(wanted) <= _MOST_DIGITS
        result = questions.change_state(given.node, int(wanted) if is_id else wanted)
    except ControlError as error:
        if error.kind != "refused":
            raise
        # As `ros2 lifecycle set` lists them.
        offered = [f"\n- {t['label']} [{t['id']}]" for t in questions.transitions(given.node)]
        print(
            f"rosbase: {error}\nUnknown transition requested, available ones are:"
            f"{''.join(offered)}",
            file=sys.stderr,
        )
        return 1
    if result["successful"]:
        print("Transitioning successful")
        return 0
    reason = f": {result['reason']}" if result.get("reason") else ""
    print(f"Transitioning failed{reason}", file=sys.stderr)
    return 1
