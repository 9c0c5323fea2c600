"""What an author has not written yet, or has got wrong."""

from rosbase.contracts.transport import OnFrame, SimulatedDevice, Transport, TransportContext
from rosbase.testing import TransportCapabilities
from rosbase.testing.transport_kit.author import TransportAuthor
from support.fifo import FifoContract, FifoDevice, make_transport
from support.mutants.mutant import Wrapped, mutant


@mutant("every-call-is-written", "open is not written yet")
class LeavesOpenUnwritten(Wrapped):
    def open(self) -> None:
        raise NotImplementedError


@mutant("every-call-is-written", "start is not written yet")
class LeavesStartUnwritten(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        raise NotImplementedError


@mutant("every-call-is-written", "health gave None")
class HasNoHealth(Wrapped):
    @property
    def health(self) -> None:  # type: ignore[override]  # which is what is wrong
        return None


@mutant("a-peer-plays-the-device", "make_peer gave None")
class MakesNoPeer(FifoContract):
    def make_peer(self) -> None:  # type: ignore[override]  # which is what is wrong
        return None


@mutant("a-peer-plays-the-device", "make_peer is not written yet")
class WritesNoPeer(FifoContract):
    def make_peer(self) -> SimulatedDevice:
        raise NotImplementedError


@mutant("a-peer-plays-the-device", "str has no parameters and no send and no close")
class MakesAPeerThatDoesNothing(FifoContract):
    def make_peer(self) -> str:  # type: ignore[override]  # which is what is wrong
        return "a peer"


@mutant("a-peer-plays-the-device", "has no simulated device")
class HasNoSimulatedDevice(FifoContract):
    make_peer = TransportAuthor.make_peer


class Plain:
    """A peer that can do what every peer can, and no more."""

    def __init__(self, peer: SimulatedDevice) -> None:
        self.parameters = peer.parameters
        self.send = peer.send
        self.close = peer.close


@mutant("the-peer-can-do-what-is-declared", "can_unplug is declared, and Plain has no unplug()")
class DeclaresTooMuch(FifoContract):
    capabilities = TransportCapabilities(can_unplug=True)

    def make_peer(self) -> SimulatedDevice:
        return Plain(super().make_peer())


@mutant("a-transport-is-made", "make_transport gave None")
class MakesNoTransport(FifoContract):
    def make_transport(  # type: ignore[override]  # which is what is wrong
        self, peer: SimulatedDevice, context: TransportContext
    ) -> None:
        return None


@mutant("a-transport-is-made", "abstract")
class LeavesACallOut(FifoContract):
    def make_transport(self, peer: SimulatedDevice, context: TransportContext) -> Transport:
        class WithoutOpen(Wrapped):
            open = Transport.open

        return WithoutOpen(peer.parameters, context)


@mutant("a-transport-is-made", "names no installed transport")
class NamesNoTransport(FifoContract):
    transport = ""
    plugin = TransportAuthor.plugin


class LeavesReadUnwritten(FifoDevice):
    def fileno(self) -> int:
        raise NotImplementedError("give the descriptor")


class LeavesDiscardUnwritten(FifoDevice):
    def discard_input(self) -> None:
        raise NotImplementedError("forget what came before")


class LeavesCloseUnwritten(FifoDevice):
    def close(self) -> None:
        super().close()
        raise NotImplementedError("close the device")


@mutant("every-call-is-written", "is not written yet: give the descriptor")
class HasADeviceWithoutDescriptor(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, device=LeavesReadUnwritten)


@mutant("every-call-is-written", "start is not written yet: forget what came before")
class HasADeviceThatForgetsNothing(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, device=LeavesDiscardUnwritten)


@mutant("every-call-is-written", "is not written yet: close the device")
class HasADeviceThatDoesNotClose(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, device=LeavesCloseUnwritten)
