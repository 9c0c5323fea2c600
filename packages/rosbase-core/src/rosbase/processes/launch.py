"""Start a child under its guardian: a shell command, or a node in its own Python."""

import errno
import multiprocessing
import os
import pickle
import shutil
import socket
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from multiprocessing import spawn
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

from attrs import evolve, field, frozen

from rosbase.errors import ConfigurationError
from rosbase.local import process_bus
from rosbase.local.link import Link
from rosbase.logger.environment import FILE_VARIABLES
from rosbase.processes.mark import Mark, marked_environment
from rosbase.processes.terminal import open_terminal
from rosbase.roles.recording import RECORD_VARIABLE
from rosbase.runtime.signal_masks import hold_signals

__all__ = [
    "GUARDIAN",
    "CommandLaunch",
    "GuardianProcess",
    "Launch",
    "Launched",
    "NodeLaunch",
    "Order",
    "start_guarded",
]

GUARDIAN = str(Path(__file__).with_name("guardian.py"))
"""Path of the script that guards a child."""
# The module search path comes first, so that the rest can be found as it is found here; and
# before that, nothing is found in the current folder.
_NODE = (
    "import sys; sys.path[:] = filter(None, sys.path); "
    "from multiprocessing.connection import Connection; "
    "link = Connection(int(sys.argv[1])); sys.path[:] = link.recv(); "
    "from rosbase.processes.node_main import main; main(link)"
)
# Whatever a user has decided about it counts more.
_BY_DEFAULT = {"PYTHONUNBUFFERED": "1"}
_ON_A_TERMINAL = {"TERM": "dumb"}


@frozen
class Order:
    """Arguments of a launch: the mark of its processes, and the callbacks."""

    mark: Mark
    """Mark that all of its processes carry."""
    on_record: Callable[[int, str, bool], object]
    """Called with each record of a node, as by `Link`, on a thread of its link."""
    on_fault: Callable[[str], object]
    """Called, on a thread of its link, when a node sends unreadable data."""


class GuardianProcess(Protocol):
    """A guardian's process: a `subprocess.Popen`, or one that another process has started."""

    @property
    def pid(self) -> int:
        """Process id."""
        ...

    def send_signal(self, sig: int) -> None:
        """Send a signal; do nothing if it has ended."""
        ...

    def kill(self) -> None:
        """Send SIGKILL; do nothing if it has ended."""
        ...

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end; return 0 if it has ended in order.

        Raises:
            subprocess.TimeoutExpired: It has not ended within that many seconds.
        """
        ...


@frozen
class Launched:
    """A child that has just been started, and its connections to this process."""

    guardian: GuardianProcess
    control: socket.socket
    """Connection to the guardian: a byte stops the child, and so does closing it.

    It delivers the guardian's reports.
    """
    output: int
    """Descriptor of the child's output."""
    link: Link | None
    """Topics that it shares with this process, if it is a node."""


class Launch(ABC):
    """Description of how to start one child, any number of times."""

    on_a_terminal: bool = False
    """Whether it writes to its own terminal instead of a pipe."""

    @abstractmethod
    def start(self, order: Order) -> Launched:
        """Start the child.

        Raises:
            OSError: The machine has no more processes, threads or descriptors to give.
        """


@frozen
class CommandLaunch(Launch):
    """Starts a shell command."""

    command: str
    on_a_terminal: bool = field(default=False, kw_only=True)

    def start(self, order: Order) -> Launched:
        """Start the command. A command writes output, but no records."""
        argv = ["/bin/sh", "-c", self.command]
        return start_guarded(argv, order, on_a_terminal=self.on_a_terminal)


@frozen
class NodeLaunch(Launch):
    """Starts a Python process that makes a node of a class and spins it."""

    name: str
    pickled_class: bytes
    log_level: int
    on_a_terminal: bool = field(default=False, kw_only=True)

    @classmethod
    def of(
        cls, name: str, node_class: Any, log_level: int, *, on_a_terminal: bool = False
    ) -> "NodeLaunch":
        """Return the launch of a class, after checking what the child would otherwise find out.

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
        return cls(name, pickled, log_level, on_a_terminal=on_a_terminal)

    def start(self, order: Order) -> Launched:
        """Start the node."""
        surroundings = _surroundings(self.name)
        node = (self.pickled_class, self.name, self.log_level)
        with ExitStack() as undo:
            ours, theirs = socket.socketpair()
            connection: Connection[Any, Any] = Connection(ours.detach())
            link = Link(process_bus(), connection, self.name, order.on_record, order.on_fault)
            undo.callback(link.close)
            undo.enter_context(theirs)
            try:
                link.start(surroundings["sys_path"], surroundings, node)
            except RuntimeError as error:
                raise OSError(errno.EAGAIN, str(error)) from error
            argv = [_python(), *_options(), "-c", _NODE, str(theirs.fileno())]
            launched = start_guarded(
                argv, order, on_a_terminal=self.on_a_terminal, link_fd=theirs.fileno(), folder="/"
            )
            theirs.close()
            undo.pop_all()
        return evolve(launched, link=link)


def _surroundings(name: str) -> dict[str, Any]:
    """Return multiprocessing's data for a child, which lets it find and import the main module.

    Raises:
        FileNotFoundError: The working directory does not exist any more.
    """
    chosen = multiprocessing.get_start_method(allow_none=True)
    try:
        surroundings = spawn.get_preparation_data(name)
    except FileNotFoundError as error:
        raise FileNotFoundError(
            errno.ENOENT, f"node '{name}': the working directory does not exist any more"
        ) from error
    finally:
        if chosen is None:
            # Asking has chosen one, and that is for the program to do.
            multiprocessing.set_start_method(None, force=True)
    # It is started elsewhere, and Python remembers what it has looked up under a relative path.
    surroundings["sys_path"] = [os.path.abspath(entry) for entry in surroundings["sys_path"]]
    # The key is for connections over a network, and refuses to be pickled.
    return {k: v for k, v in surroundings.items() if k not in ("authkey", "start_method")}


def _inherited() -> dict[str, str]:
    """Return the environment of a child, without the log file and the recording.

    This process writes its output, and records its messages.
    """
    own = {*FILE_VARIABLES, RECORD_VARIABLE}
    return {name: text for name, text in os.environ.items() if name not in own}


def _python() -> str:
    """Return the path of the Python that multiprocessing would start."""
    python = os.fsdecode(spawn.get_executable() or sys.executable)
    return os.path.abspath(shutil.which(python) or python)


def _options() -> list[str]:
    """Return the options of this interpreter that multiprocessing hands on, such as `-O`."""
    command = spawn.get_command_line()
    return command[1 : command.index("-c")] if "-c" in command else []


def start_guarded(
    argv: list[str],
    order: Order,
    *,
    on_a_terminal: bool,
    link_fd: int = -1,
    folder: str | None = None,
    environment: Mapping[str, str] | None = None,
) -> Launched:
    """Start a command under a guardian.

    Args:
        argv: The command; its program is a path.
        order: Arguments of the launch.
        on_a_terminal: Whether it writes to a terminal.
        link_fd: A descriptor that the command inherits, or -1.
        folder: Folder where it is started; by default the working directory.
        environment: Its environment; by default this process's, without the log file.

    Raises:
        OSError: The machine has no more processes or descriptors to give.
    """
    own = _ON_A_TERMINAL if on_a_terminal else {}
    environment = _inherited() if environment is None else environment
    # Until the guardian handles signals, one of them would end it with a traceback.
    with ExitStack() as undo, ExitStack() as for_the_child, hold_signals():
        ours, theirs = socket.socketpair()
        undo.callback(ours.close)
        for_the_child.callback(theirs.close)
        output, write_end = open_terminal() if on_a_terminal else os.pipe()
        undo.callback(os.close, output)
        for_the_child.callback(os.close, write_end)
        for fd in (ours.fileno(), output):
            os.set_blocking(fd, False)
        guardian = subprocess.Popen(
            [
                *(_python(), "-I", "-S", GUARDIAN),
                *(str(theirs.fileno()), str(os.getpid()), str(link_fd)),
                *argv,
            ],
            stdin=subprocess.DEVNULL,
            stdout=write_end,
            stderr=write_end,
            pass_fds=[fd for fd in (theirs.fileno(), link_fd) if fd >= 0],
            start_new_session=True,
            env=_BY_DEFAULT | marked_environment(order.mark, environment) | own,
            cwd=folder,
        )
        undo.pop_all()
    return Launched(guardian, ours, output, None)
