"""Register the transport `serial`, and its check. Imports no device library."""

from collections.abc import Iterable, Mapping

from imu_serial.config import PARAMETERS, SerialConfig
from rosbase import (
    CheckContext,
    CheckPlugin,
    DeviceTransport,
    Finding,
    LineFramer,
    OpenDevice,
    ParameterValue,
    SimulatedDevice,
    Transport,
    TransportContext,
    TransportPlugin,
    hookimpl,
)

__all__ = ["rosbase_checks", "rosbase_transports"]

_HINTS = {
    "not_data": "a device may say so when it starts",
    "not_utf8": "check the baud rate",
    "overlong": "is it the right device and baud rate?",
    "unended": "is it the right device and baud rate?",
}


def _create(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    config = SerialConfig.from_values(values)
    return DeviceTransport(
        _opener(config, context),
        context,
        framer=LineFramer(),
        waits_for_device=config.wait_for_device,
        reopen_after_s=config.reopen_after_silence,
    )


def _opener(config: SerialConfig, context: TransportContext) -> OpenDevice:
    if (address := config.address) is not None:
        from imu_serial.network import Dialer

        return Dialer(config, address, context.clock).open
    from imu_serial.port import Port

    return lambda: Port(config)


def _simulate() -> SimulatedDevice:
    from imu_serial.simulator import SimulatedPort

    return SimulatedPort()


def _check(context: CheckContext) -> Iterable[Finding]:
    from imu_serial.check import check_ports

    return check_ports(context)


@hookimpl
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Register lines from a serial port."""
    yield TransportPlugin(
        "serial",
        "lines from a serial port",
        _create,
        parameters=PARAMETERS,
        simulate=_simulate,
        hints=_HINTS,
    )


@hookimpl
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Register the check of the ports of this machine."""
    yield CheckPlugin("serial", "serial ports, and who may open them", _check)
