"""rclpy's default context, lent to programs that have not called `rclpy.init()`.

Everything in rclpy that is given no executor or context uses the default context, such as
`rclpy.spin_until_future_complete(node, future)` and `rclpy.create_node`. Without one it raises a
TypeError. So there is one as long as a backend is open. It installs no signal handlers.
"""

import threading
from collections.abc import Sequence
from typing import Any, Protocol

import rclpy
from rclpy.signals import SignalHandlerOptions

__all__ = ["Borrower", "borrow", "give_back", "is_lent"]


class Borrower(Protocol):
    """A backend that needs the context."""

    def on_lent_context_end(self) -> object:
        """Handle the end of the context, on the thread that ends it: take no locks of rclpy."""
        ...

    def on_own_init(self) -> object:
        """Handle `rclpy.init()` of the program, whose context takes the place of the lent one."""
        ...


class _Loan:
    """The context that this process lends, and to whom."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._context: Any = None
        self._borrowers: list[Borrower] = []

    @property
    def is_active(self) -> bool:
        return self._context is not None and self._context is rclpy.get_default_context()

    def borrow(self, borrower: Borrower, arguments: Sequence[str]) -> None:
        with self._lock:
            if not rclpy.ok():
                self._lend(arguments)
            if self.is_active:
                self._borrowers.append(borrower)

    def give_back(self, borrower: Borrower) -> None:
        with self._lock:
            if borrower not in self._borrowers:
                return
            self._borrowers.remove(borrower)
            if self._borrowers:
                return
            context, self._context = self._context, None
        self._end(context)

    def _lend(self, arguments: Sequence[str]) -> None:
        self._context = None
        if rclpy.get_default_context().handle is not None:
            # One that has ended, such as by a signal handler of rclpy. This replaces it.
            rclpy.try_shutdown()
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
        self._context = context = rclpy.get_default_context()
        self._borrowers.clear()
        # It can be initialised once only, and a program's own `rclpy.init()` is still to come.
        context.init = self._give_way
        context.on_shutdown(self._on_end)

    def _give_way(self, args: Any = None, **options: Any) -> None:
        """Initialise the default context for the program, in place of the lent one."""
        with self._lock:
            context, self._context = self._context, None
            borrowers, self._borrowers = self._borrowers, []
        self._end(context)
        rclpy.get_default_context().init(args, **options)
        for borrower in borrowers:
            borrower.on_own_init()

    def _end(self, context: Any) -> None:
        if context is rclpy.get_default_context():
            # Also makes a new default context, for the next `rclpy.init()`.
            rclpy.try_shutdown()

    def _on_end(self) -> None:
        # Empty if it is this object that ends the context.
        for borrower in list(self._borrowers) if self._context is not None else ():
            borrower.on_lent_context_end()


_loan = _Loan()


def is_lent() -> bool:
    """Return whether the default context is lent, and not of the program."""
    return _loan.is_active


def borrow(borrower: Borrower, arguments: Sequence[str]) -> None:
    """Initialise the default context, unless the program has done so.

    Args:
        borrower: Who needs it, until it gives it back.
        arguments: Arguments for ROS of the context.
    """
    _loan.borrow(borrower, arguments)


def give_back(borrower: Borrower) -> None:
    """End the lent context, if this was the last one who needed it."""
    _loan.give_back(borrower)
