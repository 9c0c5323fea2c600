"""`udp` keeps the promises of a transport."""

from rosbase.testing import TransportContract


class TestUdp(TransportContract):
    transport = "udp"
