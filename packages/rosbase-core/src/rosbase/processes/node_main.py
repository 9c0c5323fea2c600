"""The main program of a node's own process. Its bootstrap is in `launch.py`."""

import logging
import os
import pickle
import signal
import sys
from multiprocessing import spawn
from multiprocessing.connection import Connection
from types import FrameType
from typing import Any

from rosbase.local import process_bus
from rosbase.local.link import Link
from rosbase.processes.registration import refuse_registration
from rosbase.roles.connection import name_lone_nodes

__all__ = ["main"]

_OURS = logging.getLogger("rosbase")
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class _ToManager(logging.Handler):
    """Sends records to the manager, which writes them into its own log.

    A level that was set for a logger of this process has decided already. Otherwise, the level of
    the manager decides.
    """

    def __init__(self, link: Link) -> None:
        super().__init__()
        self._link = link

    def emit(self, record: logging.LogRecord) -> None:
        is_chosen = _has_own_level(logging.getLogger(record.name))
        self._link.send_record(record.levelno, self.format(record), is_chosen=is_chosen)


def main(connection: "Connection[Any, Any]") -> None:
    """Make the node that the manager asks for, and spin it until it is stopped."""
    for number in _SIGNALS:
        # While modules are imported and the node is built; spinning has its own way.
        signal.signal(number, _leave)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
    os.set_inheritable(connection.fileno(), False)
    surroundings, (node, name, log_level) = connection.recv(), connection.recv()
    refuse_registration(
        "this is a child process, importing the main module of the program: put what starts "
        "the program under `if __name__ == '__main__':`"
    )
    spawn.prepare(surroundings)
    node_class = pickle.loads(node)
    refuse_registration("")
    name_lone_nodes(name)
    link = Link(process_bus(), connection, "manager")
    link.start()
    _log_to(link, log_level)
    try:
        node_class().start_spin_standalone()
    finally:
        link.close()


def _log_to(link: Link, level: int) -> None:
    _OURS.setLevel(level)
    _OURS.addHandler(_ToManager(link))
    _OURS.propagate = False


def _has_own_level(logger: logging.Logger) -> bool:
    """Return whether a level was set for this logger, or for one between it and all of rosbase."""
    at: logging.Logger | None = logger
    while at is not None and at is not _OURS:
        if at.level != logging.NOTSET:
            return True
        at = at.parent
    return False


def _leave(signum: int, frame: FrameType | None) -> None:
    sys.exit(0)
