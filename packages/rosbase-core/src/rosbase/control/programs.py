"""The programs that run in this process: managers, nodes without a manager, launchers.

`offered` shows one to clients while it runs. The first one opens the control socket of the
process, the last one closes it.
"""

import os
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from attrs import frozen

from rosbase.contracts.backend import Backend
from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.recording import Recording
from rosbase.control.recent_log import recent_log
from rosbase.errors import ConfigurationError, ControlError
from rosbase.lifecycle import ManagedNode
from rosbase.logger import RosbaseLogger
from rosbase.runtime.rate import LoopStats

if TYPE_CHECKING:
    from rosbase.control.server import ControlServer

__all__ = [
    "CONTROL_VARIABLE",
    "Phase",
    "Program",
    "RunningNode",
    "is_control_on",
    "keep_log",
    "may_be_offered",
    "offered",
    "running_programs",
]

CONTROL_VARIABLE = "ROSBASE_CONTROL"
"""Environment variable that turns the control socket off."""

Phase: TypeAlias = Literal["starting", "handshake", "bringing up", "running", "stopping"]

_SWITCH = {"": True, "on": True, "1": True, "true": True, "off": False, "0": False, "false": False}
_CURE = f"set XDG_RUNTIME_DIR to a folder of your own, or {CONTROL_VARIABLE}=off to do without"


@frozen
class RunningNode:
    """A node of a program."""

    name: str
    """Full name, as other programs see it. A plain node has the name of its manager."""
    key: str
    """Name in `nodes` of the manager; empty for the node of the program itself."""
    class_name: str
    connection: NodeConnection | None
    """Its connection; None for a component that uses nothing of rosbase."""
    lifecycle: ManagedNode | None = None


class Program:
    """A program, as clients see it. Subclasses describe managers, lone nodes and launchers.

    All of it is called on the thread of the control socket, also while the main loop blocks.
    """

    kind = "node"
    """`manager`, `node` or `launcher`."""
    phase: Phase = "starting"
    """How far it is; its owner sets it."""
    backend: Backend | None = None
    """Its connection; None for a launcher."""
    loop_stats: LoopStats | None = None
    """Statistics of its main loop, if it has one."""
    logger: RosbaseLogger | None = None
    """Its log; set by `offered`."""
    started_ns = 0
    """Start of its run on the machine's monotonic clock; set by `offered`."""

    @property
    def recording(self) -> Recording | None:
        """The recording that it makes of itself, if it does."""
        return None

    @property
    def name(self) -> str:
        """Full name of the program, such as `/robot`."""
        return f"/{self.backend.node_name}" if self.backend is not None else "/"

    @property
    def class_name(self) -> str:
        """Class of the manager or node."""
        return type(self).__name__

    def nodes(self) -> list[RunningNode]:
        """Return its nodes, its own first."""
        return []

    def facts(self) -> dict[str, Any]:
        """Return what `process` says of it beside the attributes above."""
        return {}

    def request_stop(self) -> None:
        """End the program in order."""

    def answers(self) -> "Mapping[str, Callable[..., Any]]":
        """Return answers to requests that only this program has; see `control.answers`."""
        return {}


_lock = threading.Lock()
_programs: tuple[Program, ...] = ()
_server: "ControlServer | None" = None


def running_programs() -> tuple[Program, ...]:
    """Return the programs of this process, in the order of their start."""
    return _programs


def is_control_on() -> bool:
    """Return whether the environment allows a control socket.

    Raises:
        ConfigurationError: The variable is neither on nor off.
    """
    text = os.environ.get(CONTROL_VARIABLE, "")
    if text.lower() not in _SWITCH:
        raise ConfigurationError(f"{CONTROL_VARIABLE} is on or off, not {text!r}")
    return _SWITCH[text.lower()] and hasattr(socket, "AF_UNIX")


def keep_log() -> None:
    """Keep the records of this process from now on, for clients that come later.

    Raises:
        ConfigurationError: The environment says neither on nor off.
    """
    if is_control_on():
        recent_log.start()


def may_be_offered(backend: Backend, *, wanted: bool) -> bool:
    """Return whether clients may see a program, and keep the log from now on if they may.

    Programs in virtual time are a test's own.

    Args:
        backend: Its connection.
        wanted: Whether the program wants it.

    Raises:
        ConfigurationError: The environment says neither on nor off.
        TypeError: `wanted` is no bool. Programs may have a keyword of that name for a component.
    """
    if not isinstance(wanted, bool):
        raise TypeError(f"control is True or False, not {wanted!r}")
    is_on = is_control_on() and wanted and not backend.is_in_virtual_time
    if is_on:
        recent_log.start()
    return is_on


@contextmanager
def offered(program: Program | None, logger: RosbaseLogger) -> Iterator[None]:
    """Show a program to clients while the block runs.

    Args:
        program: The program; None for one that no client shall see.
        logger: Logs a warning if the socket cannot be opened. The program runs without.
    """
    if program is None:
        yield
        return
    try:
        _begin(program, logger)
        yield
    finally:
        _end(program)


def _begin(program: Program, logger: RosbaseLogger) -> None:
    global _programs, _server  # noqa: PLW0603 - they concern the process
    # Only now: a program without a socket needs none of it.
    from rosbase.control.server import CLOCK, ControlServer

    program.started_ns, program.logger = CLOCK.monotonic_ns(), logger
    with _lock:
        _programs = (*_programs, program)
        if _server is not None:
            return
        try:
            _server = ControlServer()
            _server.start()
        except (ControlError, OSError, RuntimeError) as error:
            _server = None
            logger.warning(f"there is no control socket: {error}; {_CURE}")


def _end(program: Program) -> None:
    global _programs, _server  # noqa: PLW0603 - they concern the process
    with _lock:
        _programs = tuple(one for one in _programs if one is not program)
        if _programs:
            return
        server, _server = _server, None
        if server is not None:
            server.close()
        recent_log.stop()


def _forget_in_child() -> None:
    """Leave the socket to the parent. Called in a child after a fork."""
    global _programs, _server, _lock  # noqa: PLW0603 - they concern the process
    # Another thread of the parent may have held it.
    _lock = threading.Lock()
    server, _server, _programs = _server, None, ()
    recent_log.stop()
    if server is not None:
        server.forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_in_child)
