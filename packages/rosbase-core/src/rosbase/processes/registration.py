"""The two functions that programs call, and the children that no manager has claimed yet."""

import atexit
import os
import weakref
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from rosbase.contracts.names import check_node_name
from rosbase.control.programs import keep_log
from rosbase.errors import ConfigurationError
from rosbase.logger import RosbaseLogger
from rosbase.logger.environment import apply_environment
from rosbase.processes.child import ChildProcess
from rosbase.processes.launch import CommandLaunch, Launch, NodeLaunch
from rosbase.processes.observed import is_replay, observed
from rosbase.processes.restart import RestartPolicy, RestartWhen
from rosbase.processes.supervisor import Supervisor
from rosbase.roles.classes import check_class

__all__ = [
    "ChildProcesses",
    "refuse_registration",
    "register_multiprocess_nodes",
    "shutdown_multiprocess_nodes",
    "shutdown_unclaimed",
]

Restart = RestartWhen | RestartPolicy
Chosen = bool | Collection[str] | Mapping[str, bool]

_refusal = ""


class ChildProcesses(Mapping[str, ChildProcess]):
    """The children of one manager, by name."""

    def __init__(self, children: Mapping[str, ChildProcess], logger: RosbaseLogger) -> None:
        self._children = dict(children)
        # A recording has what comes of them.
        has_any = bool(children) and not is_replay()
        self._supervisor = Supervisor(list(children.values()), logger) if has_any else None

    def __getitem__(self, name: str) -> ChildProcess:
        """Return the child of that name."""
        return self._children[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names, in order of registration."""
        return iter(self._children)

    def __len__(self) -> int:
        """Return the number of children."""
        return len(self._children)

    @property
    def exit_status(self) -> int:
        """Exit status of the first required child that ended for good; 0 while there is none."""
        supervisor = self._supervisor
        return observed(lambda: supervisor.judge.status if supervisor is not None else 0)

    def start(self) -> None:
        """Start all children.

        Raises:
            OSError: One could not be started. Those before it have been stopped.
        """
        if self._supervisor is not None:
            self._supervisor.start()
            _running.add(self)
            _unclaimed.append(self)

    def claim(self, logger: RosbaseLogger, on_required_end: Callable[[], object]) -> None:
        """Hand the children to a manager, which stops them and logs their output.

        Args:
            logger: The logger of the manager.
            on_required_end: Called, on any thread, when a required child has ended for good.
        """
        if self in _unclaimed:
            _unclaimed.remove(self)
        if self._supervisor is not None:
            self._supervisor.journal.logger = logger
            self._supervisor.judge.have_called(on_required_end)

    def stopping_soon(self) -> None:
        """Note that a stop was requested: the end of a child has no consequences any more.

        The child is not started again, and the program does not end because of it. Call it
        from any thread or signal handler, any number of times.
        """
        if self._supervisor is not None:
            self._supervisor.stopping_soon()

    def shutdown(self) -> None:
        """Stop all children, in bounded time. Do nothing if they are stopped."""
        if self._supervisor is not None:
            self._supervisor.stop()
        if self in _unclaimed:
            _unclaimed.remove(self)

    # Two groups are never the same, whatever is in them.
    __eq__ = object.__eq__
    __hash__ = object.__hash__


_unclaimed: list[ChildProcesses] = []
_running: "weakref.WeakSet[ChildProcesses]" = weakref.WeakSet()


def register_multiprocess_nodes(
    mp_nodes_dict: Mapping[str, Any] | None = None,
    cmds_dict: Mapping[str, str] | None = None,
    *,
    restart: Restart | Mapping[str, Restart] = "never",
    required: Chosen = False,
    pty: Chosen = False,
    logger: RosbaseLogger | None = None,
) -> ChildProcesses:
    """Start nodes and shell commands in child processes.

    Pass the result to `start_main_loop_timer`, which stops them when the manager ends. They
    are also stopped if the manager cannot be built, if the program ends in another way and, on
    Linux, if it is killed.

    Args:
        mp_nodes_dict: Node classes by name. Each is made without arguments, in a new Python
            process, on the backend that `ROSBASE_BACKEND` names. The key is the name of its node.
            Topics of the local backend are shared between the processes.
        cmds_dict: Commands for `/bin/sh` by name, with pipes and a trailing `&` if you like.
        restart: Policy for a child that ends by itself: `never`, `on-failure`, `always` or a
            `RestartPolicy`; for all of them, or by name.
        required: The children that the program requires: their names, or True for all. When one
            ends for good, with any status, the manager cleans up and the program ends with that
            status.
        pty: The children that get a pseudo-terminal for their output: their names, or True for
            all. For programs that buffer or change their output if it is a pipe.
        logger: Logs output and ends until a manager replaces it with its own.

    Returns:
        The children, by name.

    Raises:
        BackendError: ROS would refuse the name of a node.
        ConfigurationError: A name is used twice or unknown, another process cannot find a node's
            class, or this is not a POSIX system.
        OSError: The system refuses to start one. Those before it have been stopped.
        RuntimeError: This is the child itself, importing the program's main module.
        TypeError: An instance is given instead of a class.
    """
    if _refusal:
        raise RuntimeError(_refusal)
    if os.name != "posix":
        raise ConfigurationError("child processes need a POSIX system")
    # A child may have something for the log before there is a manager.
    apply_environment()
    logger = logger or RosbaseLogger("processes")
    nodes, commands = mp_nodes_dict or {}, cmds_dict or {}
    names = [*nodes, *commands]
    on_terminals = _chosen("pty", pty, names)
    launches = _launches(nodes, commands, on_terminals, logger)
    policies = _policies(restart, launches)
    needed = _chosen("required", required, names)
    children = {
        name: ChildProcess(name, launch, policies[name], is_required=name in needed)
        for name, launch in launches.items()
    }
    processes = ChildProcesses(children, logger)
    # They may say something before there is a manager.
    keep_log()
    processes.start()
    return processes


def shutdown_multiprocess_nodes(processes: ChildProcesses | None) -> None:
    """Stop the children: SIGINT, SIGTERM, SIGKILL, with bounded waits.

    Do nothing if they are stopped.
    """
    if isinstance(processes, ChildProcesses):
        processes.shutdown()


def shutdown_unclaimed() -> None:
    """Stop the children that no manager has taken over. Called when one cannot be built."""
    for processes in list(_unclaimed):
        processes.shutdown()


def refuse_registration(why: str) -> None:
    """Make every registration raise RuntimeError with that message; an empty one ends this."""
    global _refusal  # noqa: PLW0603 - it concerns the process
    _refusal = why


@atexit.register
def _shutdown_all() -> None:
    for processes in list(_running):
        processes.shutdown()


def _chosen(option: str, chosen: Chosen, names: Collection[str]) -> set[str]:
    """Return the names for which an option is set."""
    if isinstance(chosen, bool):
        return set(names) if chosen else set()
    if isinstance(chosen, Mapping):
        chosen = [name for name, is_set in chosen.items() if is_set]
    wanted = {chosen} if isinstance(chosen, str) else set(chosen)
    if unknown := sorted(wanted - set(names)):
        raise ConfigurationError(f"{option}: no child is called {', '.join(unknown)}")
    return wanted


def _launches(
    nodes: Mapping[str, Any],
    commands: Mapping[str, str],
    on_terminals: Collection[str],
    logger: RosbaseLogger,
) -> dict[str, Launch]:
    for name, node in nodes.items():
        check_node_name(name)
        check_class(node, f"mp_nodes_dict[{name!r}]")
        if name in commands:
            raise ConfigurationError(f"'{name}' is the name of a node and of a command")
    for name, command in commands.items():
        if not isinstance(command, str):
            raise ConfigurationError(f"command '{name}' is a text for the shell, not {command!r}")
    launches: dict[str, Launch] = {
        name: NodeLaunch.of(name, node, logger.level, on_a_terminal=name in on_terminals)
        for name, node in nodes.items()
    }
    return launches | {
        name: CommandLaunch(command, on_a_terminal=name in on_terminals)
        for name, command in commands.items()
    }


def _policies(
    restart: Restart | Mapping[str, Restart], launches: Mapping[str, Launch]
) -> dict[str, RestartPolicy]:
    by_name = restart if isinstance(restart, Mapping) else dict.fromkeys(launches, restart)
    if unknown := sorted(set(by_name) - set(launches)):
        raise ConfigurationError(f"no child is called {', '.join(unknown)}")
    try:
        return {
            name: policy if isinstance(policy, RestartPolicy) else RestartPolicy(policy)
            for name, policy in (dict.fromkeys(launches, RestartPolicy()) | dict(by_name)).items()
        }
    except ValueError:
        raise ConfigurationError(
            f"restart is one of never, on-failure, always, not {restart!r}"
        ) from None
