"""Whoever builds on `DeviceTransport` has a transport that keeps every promise."""

from support.fifo import FifoContract


class TestDeviceTransport(FifoContract):
    reconnect_limit_s = 2.0
