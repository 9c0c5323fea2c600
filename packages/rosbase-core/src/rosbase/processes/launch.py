"""Starts a child under its guardian: a shell command, or a node in a Python of its own."""

import multiprocessing
import os
import pickle
import socket
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from multiprocessing import spawn
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from attrs import frozen

from rosbase.errors import ConfigurationError
from rosbase.local import process_bus
from rosbase.local.link import Link

__all__ = ["CommandLaunch", "Launch", "Launched", "NodeLaunch", "OnRecord"]

OnRecord = Callable[[int, str], object]

_GUARDIAN = str(Path(__file__).with_name("guardian.py"))
# The module search path comes first, so that the rest can be found as it is found here.
_NODE = (
    "import sys; from multiprocessing.connection import Connection; "
    "link = Connection(int(sys.argv[1])); sys.path[:] = link.recv(); "
    "from rosbase.processes.node_main import main; main(link)"
)


@frozen
class Launched:
    """A child that has just been started, and the ends of what connects it to this process."""

    guardian: "subprocess.Popen[bytes]"
    control: socket.socket
    """To the guardian: a byte stops the child, closing it too. From it: what happens."""
    output: int
    """Descriptor from which comes what the child writes."""
    link: Link | None
    """The topics that it shares with this process, if it is a node."""


class Launch(ABC):
    """How to start one child, any number of times."""

    @abstractmethod
    def start(self, on_record: OnRecord) -> Launched:
        """Starts it; `on_record(level, text)` is called with what a node logs.

        Raises:
            OSError: The machine has no more processes or descriptors to give.
        """


@frozen
class CommandLaunch(Launch):
    """Starts a shell command."""

    command: str

    def start(self, on_record: OnRecord) -> Launched:
        """Starts it; a command does not log, it writes."""
        return _start_guarded(["/bin/sh", "-c", self.command], None, -1)


@frozen
class NodeLaunch(Launch):
    """Starts a Python that makes a node of a class and spins it."""

    name: str
    pickled_class: bytes
    log_level: int

    @classmethod
    def of(cls, name: str, node_class: Any, log_level: int) -> "NodeLaunch":
        """Finds out now what the child would otherwise find out.

        Raises:
            ConfigurationError: Another process cannot find the class.
        """
        try:
            pickled = pickle.dumps(node_class)
            can_be_found = pickle.loads(pickled) is node_class
        except Exception:
            can_be_found = False
        home = sys.modules.get(getattr(node_class, "__module__", ""))
        if not can_be_found or not hasattr(home, "__file__"):
            raise ConfigurationError(
                f"node '{name}': another process cannot find {node_class!r}; "
                "define it at the top level of a module"
            )
        return cls(name, pickled, log_level)

    def start(self, on_record: OnRecord) -> Launched:
        """Starts it."""
        ours, theirs = socket.socketpair()
        with theirs:
            link = Link(process_bus(), Connection(ours.detach()), self.name, on_record)
            try:
                argv = [sys.executable, "-c", _NODE, str(theirs.fileno())]
                launched = _start_guarded(argv, link, theirs.fileno())
            except BaseException:
                link.close()
                raise
        node = (self.pickled_class, self.name, self.log_level)
        link.start(sys.path[:], _surroundings(self.name), node)
        return launched


def _surroundings(name: str) -> dict[str, Any]:
    """What multiprocessing tells a child, so that it finds and imports the main module."""
    chosen = multiprocessing.get_start_method(allow_none=True)
    surroundings = spawn.get_preparation_data(name)
    if chosen is None:
        # Asking has chosen one, and that is for the program to do.
        multiprocessing.set_start_method(None, force=True)
    # The key is for connections over a network, and refuses to be pickled.
    return {k: v for k, v in surroundings.items() if k not in ("authkey", "start_method")}


def _start_guarded(argv: list[str], link: Link | None, link_fd: int) -> Launched:
    ours, theirs = socket.socketpair()
    output, write_end = os.pipe()
    try:
        guardian = subprocess.Popen(
            [
                *(sys.executable, "-I", "-S", _GUARDIAN),
                *(str(theirs.fileno()), str(os.getpid()), str(link_fd)),
                *argv,
            ],
            stdin=subprocess.DEVNULL,
            stdout=write_end,
            stderr=write_end,
            pass_fds=[fd for fd in (theirs.fileno(), link_fd) if fd >= 0],
            start_new_session=True,
        )
    except BaseException:
        ours.close()
        os.close(output)
        raise
    finally:
        theirs.close()
        os.close(write_end)
    os.set_blocking(ours.fileno(), False)
    os.set_blocking(output, False)
    return Launched(guardian, ours, output, link)
