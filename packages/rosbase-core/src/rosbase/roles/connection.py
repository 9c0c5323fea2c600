"""Choose the backend and the logger of a manager or a standalone node."""

import os
from collections.abc import Callable
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.logger import RosbaseLogger, make_logger

__all__ = [
    "BACKEND_VARIABLE",
    "DEFAULT_BACKEND",
    "backend_name",
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
    if isinstance(backend, Backend):
        return backend
    # Only now: finding plugins takes longer than everything else that `import rosbase` does.
    from rosbase.plugins import installed_plugins

    options = evolve(options, is_child=bool(_lone_name))
    return installed_plugins().backend(backend_name(backend)).create(options)


def open_logger(
    backend: Backend, name: str, custom: Callable[[str], Any] | None = None
) -> RosbaseLogger:
    """Return the logger of a manager or a standalone node, under its name in the backend.

    Args:
        backend: Its backend.
        name: The name of the manager or node.
        custom: A class of the application, which is called with the name.
    """
    return make_logger(
        backend.log_name or name,
        custom,
        backend.clock,
        backend.log_handler,
        has_console=backend.has_console_log,
    )


_lone_name = ""


def name_lone_nodes(name: str) -> None:
    """Give that name to the nodes of this process that have no manager and no name."""
    global _lone_name  # noqa: PLW0603 - it concerns the process
    _lone_name = name


def lone_node_name(node: object) -> str:
    """Return the name of a node without a manager and a name: by default, its class's."""
    return _lone_name or type(node).__name__
