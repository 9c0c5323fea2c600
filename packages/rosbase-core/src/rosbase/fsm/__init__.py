"""Task state machines: a table of transitions, and a machine that takes them one by one. Pure.

    machine = Machine(
        "search",
        [
            Transition("search", "grasp", when=lambda: tracker.target is not None),
            Transition("grasp", "search", when=lambda: machine.steps_in_state >= 20),
        ],
        during={"grasp": gripper.close},
    )

`handle()` then calls `machine.step()`. The state may also live in the manager, where every
component sees it: `Machine(..., holder=self)` in handlers.
"""

from rosbase.fsm.machine import Machine, StateHolder
from rosbase.fsm.transition import ANY, Action, Guard, Transition

__all__ = ["ANY", "Action", "Guard", "Machine", "StateHolder", "Transition"]
