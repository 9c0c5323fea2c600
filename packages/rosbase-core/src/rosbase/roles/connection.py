"""Which backend a manager or a lone node gets."""

import os

from attrs import evolve

from rosbase.contracts.backend import Backend, BackendOptions

__all__ = [
    "BACKEND_VARIABLE",
    "DEFAULT_BACKEND",
    "backend_name",
    "lone_node_name",
    "name_lone_nodes",
    "open_backend",
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


_lone_name = ""


def name_lone_nodes(name: str) -> None:
    """Gives that name to the nodes of this process that have no manager and no name."""
    global _lone_name  # noqa: PLW0603 - it concerns the process
    _lone_name = name


def lone_node_name(node: object) -> str:
    """The name of a node that has no manager and was given none: by default, of its class."""
    return _lone_name or type(node).__name__
