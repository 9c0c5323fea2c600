"""The conformance kit for transports: subclass `TransportContract` in a test."""

from rosbase.testing.transport_bounds import BoundChecks
from rosbase.testing.transport_calls import CallChecks
from rosbase.testing.transport_delivery import DeliveryChecks
from rosbase.testing.transport_frames import FrameChecks
from rosbase.testing.transport_health import HealthChecks
from rosbase.testing.transport_losses import LossChecks
from rosbase.testing.transport_machine import HistoryChecks
from rosbase.testing.transport_resources import ResourceChecks

__all__ = ["TransportContract"]


class TransportContract(
    HistoryChecks,
    ResourceChecks,
    HealthChecks,
    LossChecks,
    DeliveryChecks,
    FrameChecks,
    BoundChecks,
    CallChecks,
):
    """Every promise of a transport, one test each.

    The author says how to make a transport and a peer, and what the two can do; see
    `TransportAuthor`. pytest runs the rest:

    ```
    class TestUdp(TransportContract):
        transport = "udp"
    ```
    """
