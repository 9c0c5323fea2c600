"""The parameters of a serial port, and the settings made from them."""

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from imu_serial.address import Address, parse_address
from rosbase import ParameterError, ParameterSpec, ParameterValue

__all__ = ["LEAVE", "OFF", "ON", "PARAMETERS", "SerialConfig"]

LEAVE = "leave"
ON = "on"
OFF = "off"
_DEFAULT_BAUDRATE = 115_200

PARAMETERS: tuple[ParameterSpec, ...] = (
    ParameterSpec(
        "device_path",
        "/dev/ttyUSB0",
        "the port: a device file or a link to one, socket://host:port, or rfc2217://host:port",
    ),
    ParameterSpec(
        "baudrate",
        _DEFAULT_BAUDRATE,
        "bits per second, as set on the device",
        minimum=1,
        maximum=20_000_000,
    ),
    ParameterSpec(
        "wait_for_device",
        default=False,
        description="wait for an absent device, instead of failing",
    ),
    ParameterSpec(
        "dtr",
        LEAVE,
        "state of the DTR line once the port is open; a change resets many boards",
        choices=(LEAVE, ON, OFF),
    ),
    ParameterSpec(
        "rts",
        LEAVE,
        "state of the RTS line once the port is open; with DTR it resets an ESP32",
        choices=(LEAVE, ON, OFF),
    ),
    ParameterSpec(
        "reopen_after_silence",
        0.0,
        "seconds without data after which the port is closed and opened again; 0: never",
        minimum=0.0,
        maximum=86_400.0,
    ),
)
"""Parameters that the transport adds to a reader's."""


@frozen
class SerialConfig:
    """Settings of a port."""

    device_path: str
    baudrate: int
    """Bits per second."""
    wait_for_device: bool = False
    """Whether `open` leaves an absent device to the reader thread, which waits for it."""
    dtr: str = LEAVE
    """State of the line DTR after opening."""
    rts: str = LEAVE
    """State of the line RTS after opening."""
    reopen_after_silence: float = 0.0
    """Seconds without data after which the port is opened anew; 0: never."""

    @classmethod
    def from_values(cls, values: Mapping[str, ParameterValue]) -> "SerialConfig":
        """Return the settings from checked parameter values.

        Raises:
            ParameterError: The port is a URL that cannot be used, or does not support the
                settings.
        """
        known: dict[str, Any] = {
            spec.name: values.get(spec.name, spec.default) for spec in PARAMETERS
        }
        config = cls(**known)
        config._check()
        return config

    @property
    def address(self) -> Address | None:
        """Address of the port on a network; None for a file.

        Raises:
            ParameterError: It is a URL that cannot be used.
        """
        return parse_address(self.device_path)

    def _check(self) -> None:
        address = self.address
        if address is None or address.scheme != "socket":
            return
        for name, is_asked_for in (
            ("dtr", self.dtr != LEAVE),
            ("rts", self.rts != LEAVE),
            ("baudrate", self.baudrate != _DEFAULT_BAUDRATE),
        ):
            if is_asked_for:
                raise ParameterError(
                    f"parameter {name} has no effect on {address}: set it at the other end, "
                    f"or use rfc2217://"
                )
