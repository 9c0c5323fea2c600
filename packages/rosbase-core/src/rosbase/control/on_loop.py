"""Requests that change something: carried out between the ticks of the main loop."""

from collections.abc import Callable
from typing import Any

from rosbase.control.claim import Claim
from rosbase.control.programs import Program
from rosbase.control.requests import Later, Request
from rosbase.errors import ControlError

__all__ = ["on_loop"]


def on_loop(request: Request, program: Program, function: Callable[[], dict[str, Any]]) -> Later:
    """Have the main loop of a program call the function, and answer with its result.

    A request whose time is up before its turn comes is never carried out.

    Args:
        request: The request.
        program: The program.
        function: Called on the thread of the main loop. It may raise ControlError.

    Raises:
        ControlError: The program has no main loop, or is stopping.
    """
    backend = program.backend
    if backend is None:
        raise ControlError(f"{program.name} has no main loop", "refused")
    if program.phase == "stopping":
        raise ControlError(f"{program.name} is stopping", "refused")
    call = _Call(request, program, function)
    later = request.wait(call.give_up)
    backend.executor.call_as_guest(call.run)
    return later


class _Call:
    """A call for the main loop, which is made or given up."""

    def __init__(
        self, request: Request, program: Program, function: Callable[[], dict[str, Any]]
    ) -> None:
        self._request = request
        self._program = program
        self._function = function
        self._claim = Claim()

    def run(self) -> None:
        """Make the call. Called by the main loop."""
        if not self._claim.take():
            return
        try:
            answer = self._function()
        except ControlError as error:
            self._request.fail(error)
        except Exception as error:
            self._request.fail(ControlError(f"{type(error).__name__}: {error}"))
        except BaseException:
            # Such as the request to end the program, which the main loop deals with.
            self._request.fail(ControlError("the program was interrupted"))
            raise
        else:
            self._request.answer(answer)

    def give_up(self) -> str:
        """Say why there is no result; the call is not made any more, unless it has begun."""
        name = self._program.name
        if self._claim.take():
            return f"the main loop of {name} is busy: nothing was changed"
        return f"the main loop of {name} has begun with it, and is not done"
