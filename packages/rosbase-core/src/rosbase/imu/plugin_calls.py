"""Calls to a transport's plugin, and the errors that a user sees if it fails."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.device.conducted import conducted_transport
from rosbase.entries.conductor import conductor_of
from rosbase.errors import ConfigurationError, NotInstalledError, RosbaseError
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin

__all__ = ["finished", "make_transport", "simulate"]


def make_transport(
    plugin: TransportPlugin, values: Mapping[str, ParameterValue], context: TransportContext
) -> Transport:
    """Return a transport that has touched no device yet.

    While the program is recorded or replayed, it is one whose frames are recorded or replayed.

    Raises:
        ConfigurationError: The values are invalid; or the plugin is not finished, or broken.
    """
    conductor = conductor_of(context.clock)
    if conductor is None:
        return _create(plugin, values, context)
    return conducted_transport(
        conductor, plugin.name, lambda inner: _create(plugin, values, inner), context
    )


def _create(
    plugin: TransportPlugin, values: Mapping[str, ParameterValue], context: TransportContext
) -> Transport:
    with _working(plugin):
        transport = plugin.create(values, context)
    if not isinstance(transport, Transport):
        raise _broken(plugin, f"create gave {transport!r}")
    return transport


def simulate(plugin: TransportPlugin) -> SimulatedDevice:
    """Return a simulated device.

    Raises:
        ConfigurationError: There is none; or it is not finished, or broken.
    """
    if plugin.simulate is None:
        raise NotInstalledError(f"transport '{plugin.name}' has no simulated device")
    with _working(plugin):
        device = plugin.simulate()
    if device is None:
        raise _broken(plugin, "simulate gave None")
    return device


@contextmanager
def finished(plugin: TransportPlugin) -> Iterator[None]:
    """Raise a clear error where a plugin is not implemented yet.

    Raises:
        ConfigurationError: It is not implemented.
    """
    try:
        yield
    except NotImplementedError as error:
        raise ConfigurationError(f"transport '{plugin.name}' is not finished: {error}") from error


@contextmanager
def _working(plugin: TransportPlugin) -> Iterator[None]:
    try:
        with finished(plugin):
            yield
    except RosbaseError:
        raise
    except Exception as error:
        raise _broken(plugin, repr(error)) from error


def _broken(plugin: TransportPlugin, why: str) -> ConfigurationError:
    return ConfigurationError(f"transport '{plugin.name}' is broken: {why}")
