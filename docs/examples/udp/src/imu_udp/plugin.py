"""Registers the transport `udp`. Opens nothing."""

from collections.abc import Iterable, Mapping

from imu_udp.config import PARAMETERS, UdpConfig
from rosbase import (
    DeviceTransport,
    ParameterValue,
    SimulatedDevice,
    Transport,
    TransportContext,
    TransportPlugin,
    hookimpl,
)

__all__ = ["rosbase_transports"]


def _create(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    from imu_udp.listener import Listener

    config = UdpConfig.from_values(values)
    # No framer: each datagram is a frame.
    return DeviceTransport(lambda: Listener(config), context)


def _simulate() -> SimulatedDevice:
    from imu_udp.simulator import UdpDevice

    return UdpDevice()


@hookimpl
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Datagrams from a UDP port."""
    yield TransportPlugin(
        "udp", "datagrams from a UDP port", _create, parameters=PARAMETERS, simulate=_simulate
    )
