"""What is UDP's own; the rest is in test_contract.py."""

import socket

import pytest
from imu_udp.config import PARAMETERS, UdpConfig
from imu_udp.listener import Listener
from imu_udp.simulator import UdpDevice

from rosbase import DeviceBusyError, DeviceNotFoundError, ParameterError


def config(**changes: str) -> UdpConfig:
    return UdpConfig.from_values({**{spec.name: spec.default for spec in PARAMETERS}, **changes})


@pytest.mark.parametrize(
    "wrong",
    [
        {"udp_address": "5005"},
        {"udp_address": "imu.local:5005"},
        {"udp_address": "0.0.0.0:0"},
        {"udp_address": "0.0.0.0:65536"},
        {"udp_address": "::5005"},
        {"udp_sender": "imu.local"},
    ],
)
def test_what_is_no_address_is_refused_in_one_line(wrong: dict[str, str]) -> None:
    with pytest.raises(ParameterError) as error:
        config(**wrong)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("text", "host"), [("0.0.0.0:5005", "0.0.0.0"), ("[::1]:5005", "::1")])
def test_addresses_of_both_kinds_are_taken(text: str, host: str) -> None:
    assert config(udp_address=text) == UdpConfig(host, 5005, "")


def test_a_port_that_cannot_be_had_is_named() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = f"127.0.0.1:{other.getsockname()[1]}"
        with pytest.raises(DeviceBusyError, match="in use"):
            Listener(config(udp_address=taken))
    with pytest.raises(DeviceNotFoundError, match="no address of this machine"):
        Listener(config(udp_address="192.0.2.1:5005"))


def test_only_the_sender_that_is_named_is_heard() -> None:
    device = UdpDevice()
    address = str(device.parameters["udp_address"])
    for sender, heard in (("127.0.0.1", b"x"), ("192.0.2.1", b""), ("", b"x")):
        listener = Listener(config(udp_address=address, udp_sender=sender))
        device.send(b"x")
        assert listener.read() == heard
        listener.close()
    device.close()
