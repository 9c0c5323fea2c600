"""Which backend a manager or a lone node gets."""

import os

from rosbase.backend import Backend, BackendOptions

__all__ = ["BACKEND_VARIABLE", "DEFAULT_BACKEND", "open_backend"]

BACKEND_VARIABLE = "ROSBASE_BACKEND"
"""The environment variable that names the backend where a program does not."""

DEFAULT_BACKEND = "local"


def open_backend(backend: str | Backend | None, options: BackendOptions) -> Backend:
    """Opens a backend by name, or takes the one that is given.

    Raises:
        NotInstalledError: No backend of that name can be used.
    """
    if isinstance(backend, Backend):
        return backend
    # Only now: finding plugins takes longer than everything else that `import rosbase` does.
    from rosbase.plugins import installed_plugins

    name = backend or os.environ.get(BACKEND_VARIABLE) or DEFAULT_BACKEND
    return installed_plugins().backend(name).create(options)
