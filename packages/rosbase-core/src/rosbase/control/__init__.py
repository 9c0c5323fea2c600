"""Look at running programs of this user, and operate them, over a Unix socket.

`programs` and `server` are the side of the program, `client` and `fleet` the other one; `folder`
and `frames` are shared.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rosbase.control.fleet import Fleet

__all__ = ["connect"]


def connect(program: str | int | None = None, *, timeout_s: float = 1.0) -> Fleet:
    """Return the running programs of this user, to look at them and to operate them.

    Any thread may use what is returned. There is no need to close it; it can be used in a `with`
    block.

    Args:
        program: Only this one: its name, or the pid of its process.
        timeout_s: How long all programs together may take for an answer, in seconds. One that
            does not answer is named on stderr.

    Raises:
        ControlError: No program has that name, or several have.
    """
    # Programs import this package too, and need no client.
    from rosbase.control.fleet import Fleet

    fleet = Fleet(program, timeout_s)
    if program is not None:
        fleet.require()
    return fleet
