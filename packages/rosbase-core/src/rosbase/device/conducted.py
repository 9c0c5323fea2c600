"""The transport of a program that is recorded or replayed."""

from collections.abc import Callable

from rosbase.contracts.transport import Transport, TransportContext
from rosbase.device.recorded_transport import RecordedTransport
from rosbase.device.replayed_transport import ReplayedTransport
from rosbase.entries.conductor import Conductor

__all__ = ["conducted_transport"]


def conducted_transport(
    conductor: Conductor,
    name: str,
    create: Callable[[TransportContext], Transport],
    context: TransportContext,
) -> Transport:
    """Return a transport whose frames are recorded, or come from the recording.

    Args:
        conductor: Records or replays the program.
        name: Name of the transport's plugin.
        create: Makes the transport; a replay does not call it.
        context: The context that the transport would have.

    Raises:
        ConfigurationError: `create` raised it, now or when this was recorded.
    """
    if conductor.is_replay:
        return ReplayedTransport(conductor, name, context)
    return RecordedTransport(conductor, name, create, context)
