"""The optional methods of a manager that switch and handle its state, before each tick."""

import inspect
from collections.abc import Callable
from typing import Protocol

from rosbase.manager.unrun import UnrunWork
from rosbase.roles.callables import check_answer

__all__ = ["StateSwitch"]


class _Manager(Protocol):
    state: str | None
    get_state_switch: Callable[[], str | None] | None
    state_handle: Callable[..., object] | None


class StateSwitch:
    """Calls `get_state_switch` and `state_handle` of a manager, as far as it has them."""

    def __init__(self, manager: _Manager, unrun: UnrunWork) -> None:
        self._manager = manager
        self._unrun = unrun
        # Whether `state_handle` takes what the switch gave; looked up when it is first called.
        self._hands_over: bool | None = None

    @property
    def is_used(self) -> bool:
        """Whether the manager has one of the methods."""
        manager = self._manager
        return not (manager.get_state_switch is None and manager.state_handle is None)

    def step(self) -> None:
        """Call them for one tick.

        Raises:
            TypeError: `get_state_switch` returned a coroutine or a generator.
        """
        manager = self._manager
        switch = manager.get_state_switch() if manager.get_state_switch is not None else None
        if switch is not None:
            check_answer(switch, f"{type(manager).__name__}.get_state_switch")
            manager.state = switch
        if manager.state_handle is None:
            return
        if self._hands_over is None:
            self._hands_over = _takes_an_argument(manager.state_handle)
        answer = manager.state_handle(switch) if self._hands_over else manager.state_handle()
        if answer is not None:
            self._unrun.report(manager, "state_handle", answer)


def _takes_an_argument(function: Callable[..., object]) -> bool:
    kinds = {parameter.kind for parameter in inspect.signature(function).parameters.values()}
    return bool(kinds - {inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.VAR_KEYWORD})
