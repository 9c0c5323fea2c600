"""`serial` keeps the promises of a transport."""

import pytest

from rosbase.testing import TransportCapabilities, TransportContract
from support.serial_port import SerialPeer


class TestSerial(TransportContract):
    transport = "serial"
    capabilities = TransportCapabilities(
        is_stream=True,
        can_unplug=True,
        can_be_absent=True,
        waits_with={"wait_for_device": True},
        bad_frames=(b"x" * 70_000 + b"\n",),
    )
    end_limit_s = 0.5
    reconnect_limit_s = 2.0

    @pytest.fixture(autouse=True)
    def folders(self, tmp_path_factory: pytest.TempPathFactory) -> None:
        self._folders = tmp_path_factory

    def make_peer(self) -> SerialPeer:
        return SerialPeer(self._folders.mktemp("port"))
