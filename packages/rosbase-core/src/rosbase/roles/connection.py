"""Which backend and which logger a manager or a lone node gets."""

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
"""The environment variable that names the backend where a program does not."""

DEFAULT_BACKEND = "local"


def backend_name(chosen: str | None = None) -> str:
    """The name of the backend to use: the chosen one, what the environment says, or `local`."""
    return chosen or os.environ.get(BACKEND_VARIABLE) or DEFAULT_BACKEND


def open_backend(backend: str | Backend | None, options: BackendOptions) -> Backend:
    """Opens a backend by name, or takes the one that is given.

    Raises:
        NotInstalledError: No backend of that name can be used.
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
    """Return the logger of a manager or a lone node, under the name that its world has for it.

    Args:
        backend: Its backend.
        name: The name of the manager or node.
        custom: A class of the application's own, which is called with the name.
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
    """Gives that name to the nodes of this process that have no manager and no name."""
    global _lone_name  # noqa: PLW0603 - it concerns the process
    _lone_name = name


def lone_node_name(node: object) -> str:
    """The name of a node that has no manager and was given none: by default, of its class."""
    return _lone_name or type(node).__name__
