"""Register the `local` backend, by the same hook as every other."""

from collections.abc import Iterable

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.plugins import BackendPlugin, hookimpl

__all__ = ["rosbase_backends"]


def _create(options: BackendOptions) -> Backend:
    from rosbase.local.backend import LocalBackend

    return LocalBackend(options)


@hookimpl
def rosbase_backends() -> Iterable[BackendPlugin]:
    """Return the backend of the core."""
    yield BackendPlugin("local", "topics, timers and parameters within one process", _create)
