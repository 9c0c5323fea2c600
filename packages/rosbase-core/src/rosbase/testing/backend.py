"""Backend in virtual time."""

from rosbase.clock import Clock
from rosbase.contracts.backend import BackendOptions
from rosbase.local import Bus, LocalBackend
from rosbase.parameters import ParameterValue
from rosbase.testing.clock import ManualClock

__all__ = ["virtual_backend"]


def virtual_backend(
    clock: Clock | None = None, node_name: str = "test", **parameters: ParameterValue
) -> LocalBackend:
    """Return a local backend for one test, with topics of its own and virtual time.

    Args:
        clock: Its clock; a new `ManualClock` by default.
        node_name: The name of the manager or node that will use it.
        parameters: Values that override the defaults of parameters declared later.
    """
    return LocalBackend(BackendOptions(node_name, parameters, clock or ManualClock()), Bus())
