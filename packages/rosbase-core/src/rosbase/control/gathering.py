"""Ask all programs of this user at once."""

from __future__ import annotations

import os
import select
import sys

from rosbase.control.client import Connection, error_in
from rosbase.control.folder import is_alive, sockets
from rosbase.control.time_limit import TimeLimit
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from typing import Any

    Ask = tuple[str, dict[str, Any]]

__all__ = ["Replies", "ask_one", "connect_to", "gather", "name_on_stderr"]

# A program that does not answer costs a second, which must not add up over some questions.
_LEFT_OUT_S = 5.0


class Replies:
    """Answers of one process."""

    __slots__ = ("answers", "missing", "path", "pid")

    def __init__(self, pid: int, path: str, number: int) -> None:
        self.pid = pid
        self.path = path
        self.answers: list[Any] = [None] * number
        """Answer to each question, or the ControlError that came instead."""
        self.missing = number


def name_on_stderr(reason: str) -> None:
    """Say that a program is left out, so that nobody takes the rest for everything."""
    print(f"rosbase: {reason}", file=sys.stderr)


def gather(
    asks: Sequence[Ask],
    timeout_s: float = 1.0,
    pids: Iterable[int] | None = None,
    on_silent: Callable[[str], object] | None = name_on_stderr,
    silent_until: dict[str, TimeLimit] | None = None,
) -> list[Replies]:
    """Ask each program the same questions; return the replies of those that answer, by pid.

    Args:
        asks: The questions, with their arguments.
        timeout_s: How long all of them together may take.
        pids: Ask only these.
        on_silent: Called for each program that does not answer, with a line that names it.
        silent_until: Sockets of programs that are left out until some time, because they have not
            answered; this adds to it.
    """
    limit = TimeLimit(timeout_s)
    wanted = None if pids is None else set(pids)
    pending: dict[int, tuple[Connection, Replies]] = {}
    done: list[Replies] = []
    silent: list[tuple[int, str, str]] = []
    silent_until = {} if silent_until is None else silent_until
    poll = select.poll()
    try:
        for pid, path in sockets():
            if (wanted is not None and pid not in wanted) or _is_left_out(path, silent_until):
                continue
            try:
                connection = _open(pid, path, asks, timeout_s)
            except ControlError as error:
                silent.append((pid, path, str(error)))
                continue
            if connection is not None:
                pending[connection.fileno()] = (connection, Replies(pid, path, len(asks)))
                poll.register(connection, select.POLLIN)
        while pending and (ready := poll.poll(limit.left_ms)):
            for fd, _ in ready:
                _read(fd, pending, poll, done, silent)
    finally:
        for connection, _ in pending.values():
            connection.close()
    silent += [(c.pid, c.path, f"process {c.pid} does not answer") for c, _ in pending.values()]
    for _, path, reason in sorted(silent):
        silent_until[path] = TimeLimit(_LEFT_OUT_S)
        if on_silent is not None:
            on_silent(reason)
    return sorted(done, key=lambda replies: (replies.pid, replies.path))


def connect_to(pid: int, path: str = "") -> Connection:
    """Connect to the program with that pid.

    Raises:
        ControlError: There is none.
    """
    paths = [path] if path else [found for number, found in sockets() if number == pid]
    for place in paths:
        try:
            return Connection(pid, place)
        except OSError:
            # Stale, or it has just ended.
            continue
    raise ControlError(f"process {pid} has ended, or has no control socket", "unknown")


def _is_left_out(path: str, silent_until: dict[str, TimeLimit]) -> bool:
    limit = silent_until.get(path)
    return limit is not None and not limit.is_over


def ask_one(
    pid: int,
    ask: str,
    arguments: dict[str, Any],
    payload: bytes = b"",
    wait_s: float = 6.0,
) -> tuple[Any, bytes]:
    """Ask one program; return its answer, and the bytes behind it.

    Raises:
        ControlError: It refuses, does not answer in time, or has ended.
    """
    connection = connect_to(pid)
    try:
        return connection.ask(ask, arguments, payload, wait_s)
    finally:
        connection.close()


def _open(pid: int, path: str, asks: Sequence[Ask], timeout_s: float) -> Connection | None:
    """Connect and ask; return None if nobody listens there."""
    try:
        connection = Connection(pid, path)
    except BlockingIOError:
        raise ControlError(f"process {pid} takes no connections", "timeout") from None
    except OSError as error:
        if isinstance(error, ConnectionRefusedError):
            _remove_stale(pid, path)
        return None
    try:
        for ask, arguments in asks:
            connection.send(ask, arguments, wait_s=timeout_s)
    except ControlError:
        # It ended in this moment.
        connection.close()
        return None
    return connection


def _remove_stale(pid: int, path: str) -> None:
    """Remove the socket of a process that has ended without removing it.

    A program listens before its socket gets this name, so one that refuses has no owner. But a
    new process of that pid may take the name at this moment.
    """
    if not is_alive(pid):
        try:
            os.unlink(path)
        except OSError:
            # Somebody else has done so.
            pass


def _read(
    fd: int,
    pending: dict[int, tuple[Connection, Replies]],
    poll: select.poll,
    done: list[Replies],
    silent: list[tuple[int, str, str]],
) -> None:
    """Take what a program has answered; it is done when nothing is missing."""
    connection, replies = pending[fd]
    try:
        for frame, _ in connection.frames():
            number = frame.get("id")
            if isinstance(number, int) and 0 < number <= len(replies.answers):
                replies.answers[number - 1] = error_in(frame) or frame.get("ok") or {}
                replies.missing -= 1
        if replies.missing > 0:
            return
        done.append(replies)
    except ControlError as error:
        # One that ends while it is asked is simply no longer there.
        if connection.greeting is not None or "has ended" not in str(error):
            silent.append((connection.pid, connection.path, str(error)))
    poll.unregister(fd)
    del pending[fd]
    connection.close()
