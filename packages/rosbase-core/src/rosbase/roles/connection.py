"""Choose the backend and the logger of a manager or a standalone node."""

import os
from collections.abc import Callable
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.node_connection import NodeConnection
from rosbase.entries.conductor import conductor_of
from rosbase.entries.current import conducted, set_running
from rosbase.logger import RosbaseLogger, make_logger
from rosbase.logger.environment import apply_environment
from rosbase.roles.context import ManagerContext

__all__ = [
    "BACKEND_VARIABLE",
    "DEFAULT_BACKEND",
    "backend_name",
    "connect",
    "is_child",
    "lone_node_name",
    "name_lone_nodes",
    "open_backend",
    "open_logger",
]

BACKEND_VARIABLE = "ROSBASE_BACKEND"
"""Environment variable that names the backend if the program does not."""

DEFAULT_BACKEND = "local"


def backend_name(chosen: str | None = None) -> str:
    """Return the name of the backend: the chosen one, the one in the environment, or `local`."""
    return chosen or os.environ.get(BACKEND_VARIABLE) or DEFAULT_BACKEND


def open_backend(backend: str | Backend | None, options: BackendOptions) -> Backend:
    """Open a backend by name, or use the given one.

    Raises:
        NotInstalledError: No backend of that name is installed.
    """
    opened = backend if isinstance(backend, Backend) else _open(backend, options)
    if opened.conductor is not None:
        set_running(opened.conductor)
        opened.conductor.begin(opened)
    return opened


def _open(name: str | None, options: BackendOptions) -> Backend:
    # Only now: finding plugins takes longer than everything else that `import rosbase` does.
    from rosbase.plugins import installed_plugins

    options = evolve(options, is_child=is_child(), clock=conducted(options.clock))
    conductor = conductor_of(options.clock)
    if conductor is not None and conductor.is_of_middleware:
        from rosbase.local.replayed.backend import ReplayedBackend

        return ReplayedBackend(options)
    if conductor is not None and conductor.is_replay:
        # Messages that are replayed need no middleware either.
        name = DEFAULT_BACKEND
    return installed_plugins().backend(backend_name(name)).create(options)


def open_logger(
    backend: NodeConnection, name: str, custom: Callable[[str], Any] | None = None
) -> RosbaseLogger:
    """Return the logger of a manager or a standalone node, under its name in the backend.

    Args:
        backend: Its connection.
        name: The name of the manager or node.
        custom: A class of the application, which is called with the name.
    """
    apply_environment()
    return make_logger(
        backend.log_name or name,
        custom,
        backend.clock,
        backend.log_handler,
        has_console=backend.has_console_log,
    )


def connect(
    manager: ManagerContext, key: str, *, is_lifecycle: bool
) -> tuple[NodeConnection, RosbaseLogger]:
    """Return the connection and the logger of a node of a manager.

    A lifecycle node with the name of the manager is the manager's own node. A node that the
    manager did not register has no name, and shares the manager's.

    Args:
        manager: The manager.
        key: The name in `nodes`; empty for a node that was not registered.
        is_lifecycle: Whether it is a lifecycle node.
    """
    if not key or (is_lifecycle and key == manager._registration.node_name):
        return manager.backend, manager.logger
    node = manager.backend.open_node(key, is_lifecycle=is_lifecycle)
    manager.backend.connections.append(node)
    if manager._registration.has_custom_logger:
        # A class of the application may open a file: one is enough.
        return node, manager.logger
    return node, open_logger(node, f"{manager.logger.name}.{key}")


_lone_name = ""


def name_lone_nodes(name: str) -> None:
    """Give that name to the nodes of this process that have no manager and no name."""
    global _lone_name  # noqa: PLW0603 - it concerns the process
    _lone_name = name


def is_child() -> bool:
    """Return whether a manager has started this process."""
    return bool(_lone_name)


def lone_node_name(node: object) -> str:
    """Return the name of a node without a manager and a name: by default, its class's."""
    return _lone_name or type(node).__name__
