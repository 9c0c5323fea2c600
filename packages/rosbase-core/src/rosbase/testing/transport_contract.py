"""Conformance kit for transports: subclass `TransportContract` in a test."""

from rosbase.testing.transport_kit.bounds import BoundChecks
from rosbase.testing.transport_kit.calls import CallChecks
from rosbase.testing.transport_kit.delivery import DeliveryChecks
from rosbase.testing.transport_kit.frames import FrameChecks
from rosbase.testing.transport_kit.health import HealthChecks
from rosbase.testing.transport_kit.losses import LossChecks
from rosbase.testing.transport_kit.machine import HistoryChecks
from rosbase.testing.transport_kit.resources import ResourceChecks
from rosbase.testing.transport_kit.stamps import StampChecks

__all__ = ["TransportContract"]


class TransportContract(
    HistoryChecks,
    ResourceChecks,
    HealthChecks,
    LossChecks,
    StampChecks,
    DeliveryChecks,
    FrameChecks,
    BoundChecks,
    CallChecks,
):
    """All promises of a transport, one test each.

    You define how to make a transport and a peer, and their capabilities; see
    `TransportAuthor`. pytest runs the rest:

    ```
    class TestUdp(TransportContract):
        transport = "udp"
    ```
    """
