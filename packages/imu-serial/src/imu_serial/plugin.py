"""Registers the transport `serial`. Imports no device library."""

from collections.abc import Iterable, Mapping

from imu_serial.config import PARAMETERS, SerialConfig
from rosbase.device import DeviceTransport
from rosbase.framing import LineFramer
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin, hookimpl
from rosbase.transport import SimulatedDevice, Transport, TransportContext

__all__ = ["rosbase_transports"]


def _create(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    from imu_serial.port import Port

    config = SerialConfig.from_values(values)
    return DeviceTransport(
        lambda: Port(config),
        context,
        framer=LineFramer(),
        waits_for_device=config.wait_for_device,
    )


def _simulate() -> SimulatedDevice:
    from imu_serial.simulator import PtyDevice

    return PtyDevice()


@hookimpl
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Lines from a serial port."""
    yield TransportPlugin(
        "serial", "lines from a serial port", _create, parameters=PARAMETERS, simulate=_simulate
    )
