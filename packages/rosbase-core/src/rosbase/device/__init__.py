"""A whole transport for whoever can open a device that has a descriptor."""

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
