"""Ask the programs themselves whether they are ready, on their control sockets."""

import os
from collections.abc import Iterator
from typing import Any

from rosbase.control.client import Connection
from rosbase.control.folder import sockets
from rosbase.errors import ControlError
from rosbase.launcher.description import Condition
from rosbase.processes.mark import marks_in
from rosbase.processes.proc import read_of

__all__ = ["ControlReadiness", "is_ready"]

_TIMEOUT_S = 1.0
_AFTER_THE_HANDSHAKE = ("bringing up", "running")
_ACTIVE = "active"


class ControlReadiness:
    """Asks all processes of a program that have a control socket.

    A program may have several: its manager's, and one for each child process of the manager.
    They are recognised by the mark that each run of a program has in its environment.
    """

    def meets(self, key: str, condition: Condition) -> bool:
        """Return whether a program meets the condition by now."""
        processes, nodes = [], []
        for connection in _connections(key):
            try:
                processes += connection.ask("process", {}, wait_s=_TIMEOUT_S)[0]["programs"]
                nodes += connection.ask("lifecycle.list", {}, wait_s=_TIMEOUT_S)[0]["nodes"]
            except (ControlError, KeyError, TypeError):
                # It is just starting or ending, so it is not ready.
                return False
            finally:
                connection.close()
        return is_ready(condition, processes, nodes)


def is_ready(
    condition: Condition, programs: list[dict[str, Any]], nodes: list[dict[str, Any]]
) -> bool:
    """Return whether the answers of a program's processes meet a condition.

    Args:
        condition: `handshake`: every manager has passed its handshake. `lifecycle active`: all
            lifecycle nodes are active, and there is one.
        programs: The managers and lone nodes, as `process` lists them.
        nodes: The lifecycle nodes, as `lifecycle.list` does.
    """
    programs = [program for program in programs if program.get("kind") != "launcher"]
    if condition.kind == "handshake":
        return bool(programs) and all(p.get("phase") in _AFTER_THE_HANDSHAKE for p in programs)
    return bool(nodes) and all(node.get("state") == _ACTIVE for node in nodes)


def _connections(key: str) -> Iterator[Connection]:
    """Yield a connection to each process of a program that this process has started."""
    try:
        found = sockets()
    except ControlError:
        # A folder that nobody may use; each program has logged it, and is not ready.
        return
    for pid, path in found:
        marks = marks_in(read_of(pid, "environ"))
        if not any(mark.name == key and mark.manager[0] == os.getpid() for mark in marks):
            continue
        try:
            yield Connection(pid, path)
        except OSError:
            # It has ended meanwhile.
            continue
