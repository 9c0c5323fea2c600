"""`serial` keeps the promises of a transport, on a line, over TCP and over RFC 2217."""

import pytest

from rosbase.testing import TransportCapabilities, TransportContract
from support.serial_network import Rfc2217Peer, SocketPeer
from support.serial_port import SerialPeer


class TestSerial(TransportContract):
    transport = "serial"
    capabilities = TransportCapabilities(
        is_stream=True,
        can_unplug=True,
        can_be_absent=True,
        waits_with={"wait_for_device": True},
        reopens_with={"reopen_after_silence": 0.1},
        bad_frames=(b"x" * 70_000 + b"\n",),
    )
    end_limit_s = 0.5
    reconnect_limit_s = 2.0

    @pytest.fixture(autouse=True)
    def folders(self, tmp_path_factory: pytest.TempPathFactory) -> None:
        self._folders = tmp_path_factory

    def make_peer(self) -> SerialPeer:
        return SerialPeer(self._folders.mktemp("port"))


class TestSocket(TestSerial):
    def make_peer(self) -> SocketPeer:  # type: ignore[override]  # not its base's kind
        return SocketPeer()


class TestRfc2217(TestSerial):
    def make_peer(self) -> Rfc2217Peer:  # type: ignore[override]  # not its base's kind
        return Rfc2217Peer()
