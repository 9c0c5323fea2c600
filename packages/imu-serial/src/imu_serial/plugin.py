"""Registers the transport `serial`. Imports no device library."""

from collections.abc import Iterable, Mapping

from imu_serial.config import PARAMETERS, SerialConfig
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin, hookimpl
from rosbase.transport import SimulatedDevice, Transport, TransportContext

__all__ = ["rosbase_transports"]


def _create(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    from imu_serial.transport import SerialTransport

    return SerialTransport(SerialConfig.from_values(values), context)


def _simulate() -> SimulatedDevice:
    from imu_serial.simulator import PtyDevice

    return PtyDevice()


@hookimpl
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Lines from a serial port."""
    yield TransportPlugin(
        "serial", "lines from a serial port", _create, parameters=PARAMETERS, simulate=_simulate
    )
