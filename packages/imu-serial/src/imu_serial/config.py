"""The parameters of a serial port, and the settings that their values amount to."""

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from rosbase import ParameterSpec, ParameterValue

__all__ = ["PARAMETERS", "SerialConfig"]

PARAMETERS: tuple[ParameterSpec, ...] = (
    ParameterSpec(
        "device_path",
        "/dev/ttyUSB0",
        "the port: a device file, or a link such as /dev/serial/by-id/...",
    ),
    ParameterSpec(
        "baudrate",
        115_200,
        "bits per second, as the device has them",
        minimum=1,
        maximum=20_000_000,
    ),
    ParameterSpec(
        "wait_for_device",
        default=False,
        description="whether an absent device is waited for, instead of a failure",
    ),
)
"""What the transport adds to a reader's parameters."""


@frozen
class SerialConfig:
    """How to open a port."""

    device_path: str
    baudrate: int
    """Bits per second."""
    wait_for_device: bool = False
    """Whether `open` leaves an absent device to the reader thread, which waits for it."""

    @classmethod
    def from_values(cls, values: Mapping[str, ParameterValue]) -> "SerialConfig":
        """The settings from checked parameter values."""
        known: dict[str, Any] = {spec.name: values[spec.name] for spec in PARAMETERS}
        return cls(**known)
