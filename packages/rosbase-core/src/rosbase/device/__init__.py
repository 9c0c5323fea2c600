"""A complete transport for any device that has a file descriptor."""

from rosbase.device.device import Device, DeviceReport, OpenDevice, ReportingDevice
from rosbase.device.transport import STOP_TIMEOUT_S, DeviceTransport

__all__ = [
    "STOP_TIMEOUT_S",
    "Device",
    "DeviceReport",
    "DeviceTransport",
    "OpenDevice",
    "ReportingDevice",
]
