"""`mqtt` keeps the promises of a transport, with a scripted broker and with a real one."""

from pathlib import Path

import pytest

from rosbase.testing import TransportCapabilities, TransportContract
from support.mosquitto import is_installed
from support.mqtt_peers import MosquittoPeer, ScriptedPeer


class TestMqtt(TransportContract):
    transport = "mqtt"
    capabilities = TransportCapabilities(
        can_unplug=True,
        can_be_absent=True,
        waits_with={"wait_for_broker": True},
        bad_frames=(b"", b"\0\r\n", b"x" * 70_000),
    )
    end_limit_s = 0.5
    reconnect_limit_s = 2.0

    def make_peer(self) -> ScriptedPeer:
        return ScriptedPeer()


@pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")
class TestMqttOnMosquitto(TestMqtt):
    machine_examples = 8

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path: Path) -> None:
        self._folder = tmp_path

    def make_peer(self) -> MosquittoPeer:  # type: ignore[override]  # not its base's kind
        return MosquittoPeer(self._folder)
