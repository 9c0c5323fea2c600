"""What is asked of a transport's plugin, and what a user is told when it cannot answer."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.errors import ConfigurationError, NotInstalledError, RosbaseError
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin

__all__ = ["finished", "make_transport", "simulate"]


def make_transport(
    plugin: TransportPlugin, values: Mapping[str, ParameterValue], context: TransportContext
) -> Transport:
    """A transport; it has touched no device.

    Raises:
        ConfigurationError: The values cannot be; or the plugin is not finished, or broken.
    """
    with _working(plugin):
        transport = plugin.create(values, context)
    if not isinstance(transport, Transport):
        raise _broken(plugin, f"create gave {transport!r}")
    return transport


def simulate(plugin: TransportPlugin) -> SimulatedDevice:
    """A simulated device.

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
    """Says of what is not written yet that it is not.

    Raises:
        ConfigurationError: It is not.
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
