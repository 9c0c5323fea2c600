"""The transport on a real broker: everything that a broker and a network do to it."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from imu_mqtt.config import PASSWORD_VARIABLE
from imu_mqtt.packets import MOST_PACKET_BYTES
from rosbase.contracts.transport import TransportState
from rosbase.errors import DeviceNotFoundError, DevicePermissionError, TransportError
from support.certificates import Authority
from support.command import RunningRosbase
from support.mosquitto import TOPIC, Mosquitto, can_connect, free_port, is_installed, set_password
from support.mosquitto_rig import MosquittoRig
from support.stalling_proxy import StallingProxy
from support.waiting import wait_until

pytestmark = pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[MosquittoRig]:
    rig = MosquittoRig(tmp_path)
    yield rig
    rig.close()


def descriptors() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.parametrize("version", ["3.1.1", "5"])
@pytest.mark.parametrize("qos", [0, 1, 2])
def test_messages_come_through_whole_and_in_order(
    rig: MosquittoRig, version: str, qos: int
) -> None:
    broker = rig.broker()
    transport = rig.started(broker.address, mqtt_version=version, qos=qos)
    rig.prove(broker)
    for number in range(20):
        broker.publish(b"%d\n%d" % (number, number), "-q", str(qos))
    assert [rig.next() for _ in range(20)] == [b"%d\n%d" % (n, n) for n in range(20)]
    assert transport.health.frame_errors == {}


def test_the_stamp_is_the_date_of_arrival(rig: MosquittoRig) -> None:
    broker = rig.broker()
    rig.started(broker.address)
    rig.prove(broker)
    before_ns = time.time_ns()
    broker.publish(b"1")
    _, stamp_ns = rig.frames.get(timeout=20)
    assert before_ns < stamp_ns < time.time_ns()


def test_m2_a_broker_that_was_killed_is_taken_again_within_two_seconds_of_its_return(
    rig: MosquittoRig,
) -> None:
    broker = rig.broker()
    transport = rig.started(broker.address, status_topic="imu/status")
    rig.prove(broker)
    threads, fds = threading.active_count(), descriptors()
    for number in range(1, 6):
        broker.kill()
        wait_until(lambda: transport.health.state is TransportState.RECONNECTING, "the loss")
        broker.start()
        assert rig.prove(broker) < 2.0
        assert transport.health.reconnects == number
        assert (threading.active_count(), descriptors()) == (threads, fds)


def test_m2_a_broker_that_is_back_before_anybody_noticed_is_taken_again_in_two_seconds(
    rig: MosquittoRig,
) -> None:
    broker = rig.broker()
    rig.started(broker.address)
    rig.prove(broker)
    for _ in range(5):
        broker.kill()
        broker.start()
        assert rig.prove(broker) < 2.0


def test_m1_an_absent_broker_is_refused_in_one_line(rig: MosquittoRig) -> None:
    broker = rig.broker()
    broker.stop()
    transport = rig.transport(broker.address)
    with pytest.raises(DeviceNotFoundError, match=rf"^there is no broker at {broker.address}$"):
        transport.open()
    assert transport.health.state is TransportState.CLOSED
    broker.start()
    transport.open()
    assert transport.is_open


def test_m1_an_absent_broker_is_waited_for_and_picked_up_when_it_comes(
    rig: MosquittoRig, caplog: pytest.LogCaptureFixture
) -> None:
    broker = rig.broker()
    broker.stop()
    transport = rig.started(broker.address, wait_for_broker=True)
    assert transport.health.state is TransportState.RECONNECTING
    assert "there is no broker" in transport.health.last_error
    broker.start()
    assert rig.prove(broker) < 2.0
    assert transport.health.reconnects == 0, "it came late, it did not come back"
    assert len([r for r in caplog.records if "there is no broker" in r.getMessage()]) == 1


@pytest.mark.parametrize("side", ["broker", "client"])
def test_m3_a_wrong_password_is_named_tried_slowly_and_recovers_when_it_is_put_right(
    rig: MosquittoRig, side: str
) -> None:
    passwords, own = rig.folder / "passwords", rig.folder / "own"
    set_password(passwords, "imu", "right")
    own.write_text("wrong\n")
    broker = rig.broker(more=f"allow_anonymous false\npassword_file {passwords}")
    transport = rig.started(
        broker.address, username="imu", password_file=str(own), wait_for_broker=True
    )
    refused_s = time.monotonic()
    assert (
        transport.health.last_error
        == f"{broker.address} refuses the connection as 'imu': Not authorized"
    )
    if side == "client":
        own.write_text("right\n")
    else:
        set_password(passwords, "imu", "wrong")
        broker.reload()
    wait_until(lambda: transport.is_open, "the connection")
    assert 1.0 < time.monotonic() - refused_s < 6.0
    assert transport.health.last_error == ""


@pytest.mark.parametrize("version", ["3.1.1", "5"])
def test_m3_a_wrong_password_fails_in_one_line_that_does_not_tell_it(
    rig: MosquittoRig, monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    set_password(rig.folder / "passwords", "imu", "right")
    broker = rig.broker(more=f"allow_anonymous false\npassword_file {rig.folder / 'passwords'}")
    monkeypatch.setenv(PASSWORD_VARIABLE, "hush")
    transport = rig.transport(broker.address, username="imu", mqtt_version=version)
    with pytest.raises(
        DevicePermissionError, match=r"refuses the connection as 'imu': Not authorized$"
    ) as caught:
        transport.open()
    assert "hush" not in str(caught.value)
    monkeypatch.setenv(PASSWORD_VARIABLE, "right")
    transport.open()


# An acl_file of mosquitto lets everybody subscribe, and then sends nothing.
_NOBODY_SUBSCRIBES = """{"defaultACLAccess": {"publishClientSend": true,
 "publishClientReceive": true, "subscribe": false, "unsubscribe": true}}"""


@pytest.mark.parametrize("version", ["3.1.1", "5"])
def test_m3_a_subscription_that_is_not_allowed_is_named(rig: MosquittoRig, version: str) -> None:
    rules = rig.folder / "rules.json"
    rules.write_text(_NOBODY_SUBSCRIBES)
    (plugin,) = Path("/usr/lib").glob("*/mosquitto_dynamic_security.so")
    broker = rig.broker(
        more=f"allow_anonymous true\nplugin {plugin}\nplugin_opt_config_file {rules}"
    )
    transport = rig.transport(broker.address, mqtt_version=version)
    transport.open()
    with pytest.raises(DevicePermissionError, match=f"refuses the subscription to {TOPIC}"):
        transport.start(lambda frame, stamp_ns: None)


def test_m9_a_connection_that_is_cut_without_a_word_is_noticed_and_made_again(
    rig: MosquittoRig,
) -> None:
    broker = rig.broker()
    proxy = StallingProxy(broker.port)
    transport = rig.started(f"tcp://127.0.0.1:{proxy.port}", keepalive=1)
    rig.prove(broker)
    proxy.is_stalling = True
    wait_until(lambda: transport.health.state is TransportState.RECONNECTING, "the loss", 5.0)
    assert "Keep alive timeout" in transport.health.last_error
    proxy.is_stalling = False
    rig.prove(broker)
    transport.close()
    proxy.close()


@pytest.mark.parametrize("version", ["3.1.1", "5"])
def test_two_clients_of_one_name_are_named_and_the_one_that_stays_recovers(
    rig: MosquittoRig, version: str
) -> None:
    broker = rig.broker()
    first, second = (
        rig.started(broker.address, client_id="twin", mqtt_version=version) for _ in range(2)
    )
    wait_until(lambda: "another client 'twin'" in first.health.last_error, "the fault")
    second.close()
    rig.prove(broker)
    assert first.is_open


class Secure:
    """A broker behind TLS, and who signs for it."""

    def __init__(self, rig: MosquittoRig, *, host: str = "DNS:localhost", days: int = 2) -> None:
        self.authority = Authority(rig.folder, "authority")
        certificate, key = self.authority.sign("server", host=host, days=days)
        self.port = rig.broker().port
        rig.close()
        self.broker = rig.broker(
            f"listener {self.port} 127.0.0.1",
            f"certfile {certificate}",
            f"keyfile {key}",
            f"cafile {self.authority.file}",
            *self.more,
        )
        self.address = f"mqtts://localhost:{self.port}"

    more: tuple[str, ...] = ()


class SecureWebSocket(Secure):
    """A broker that speaks MQTT over a WebSocket over TLS."""

    more = ("protocol websockets",)


class Asking(Secure):
    """A broker that wants to see certificates, too."""

    more = ("require_certificate true",)


@pytest.mark.parametrize("version", ["3.1.1", "5"])
def test_tls_works_with_an_authority_of_ones_own(rig: MosquittoRig, version: str) -> None:
    secure = Secure(rig)
    rig.started(secure.address, tls_ca_file=str(secure.authority.file), mqtt_version=version)
    rig.prove(secure.broker)


def test_tls_works_with_a_certificate_of_the_client(rig: MosquittoRig) -> None:
    secure = Asking(rig)
    certificate, key = map(str, secure.authority.sign("client"))
    trusted = {"tls_ca_file": str(secure.authority.file)}
    rig.started(secure.address, **trusted, tls_cert_file=certificate, tls_key_file=key)
    rig.prove(secure.broker)
    # The broker says why and hangs up, and the network may lose the one over the other.
    with pytest.raises(
        TransportError, match=r"TLS fails: .*certificate required|ended the TLS handshake"
    ):
        rig.transport(secure.address, **trusted).open()


def test_m11_a_plain_address_of_a_port_for_tls_is_told_what_to_say(rig: MosquittoRig) -> None:
    secure = Secure(rig)
    plain = secure.address.replace("mqtts://", "tcp://")
    with pytest.raises(
        TransportError, match=r"closed the connection before it answered; .* use mqtts://"
    ):
        rig.transport(plain).open()


@pytest.mark.parametrize(
    ("host", "days", "reason"),
    [
        ("DNS:localhost", 2, "self-signed certificate"),
        ("DNS:elsewhere", 2, "Hostname mismatch"),
        ("DNS:localhost", -1, "certificate has expired"),
    ],
)
def test_m11_a_bad_certificate_is_refused_and_said_once(
    rig: MosquittoRig, caplog: pytest.LogCaptureFixture, host: str, days: int, reason: str
) -> None:
    secure = Secure(rig, host=host, days=days)
    trusted = {"tls_ca_file": str(secure.authority.file)} if "self-signed" not in reason else {}
    with pytest.raises(DevicePermissionError, match=f"TLS fails: .*{reason}") as caught:
        rig.transport(secure.address, **trusted).open()
    assert "\n" not in str(caught.value)
    caplog.clear()
    before = secure.broker.log.count("New connection")
    transport = rig.started(secure.address, wait_for_broker=True, **trusted)
    wait_until(lambda: secure.broker.log.count("New connection") >= before + 2, "another try")
    assert reason in transport.health.last_error
    assert len(caplog.records) == 1


def test_a_websocket_works(rig: MosquittoRig) -> None:
    port = free_port()
    broker = rig.broker(f"listener {port} 127.0.0.1", "protocol websockets")
    wait_until(lambda: can_connect(port), "the second listener")
    transport = rig.started(f"ws://127.0.0.1:{port}", keepalive=1, status_topic="imu/status")
    rig.prove(broker)
    broker.kill()
    wait_until(lambda: transport.health.state is TransportState.RECONNECTING, "the loss")
    broker.start()
    rig.prove(broker)


@pytest.mark.parametrize("version", ["3.1.1", "5"])
def test_a_websocket_over_tls_works_for_messages_of_any_length(
    rig: MosquittoRig, version: str
) -> None:
    secure = SecureWebSocket(rig)
    wait_until(lambda: can_connect(secure.port), "the secure listener")
    transport = rig.started(
        secure.address.replace("mqtts", "wss"),
        tls_ca_file=str(secure.authority.file),
        mqtt_version=version,
        qos=1,
    )
    rig.prove(secure.broker)
    for size in (100, 126, 65_536, MOST_PACKET_BYTES + 1, 100):
        secure.broker.publish(b"x" * size, "-q", "1")
    assert [len(rig.next()) for _ in range(4)] == [100, 126, 65_536, 100]
    # With MQTT 5 the broker is told not to send it.
    assert transport.health.frame_errors == ({} if version == "5" else {"overlong": 1})


def test_a_unix_socket_works(rig: MosquittoRig) -> None:
    # The path of a socket is short, that of a test's folder may be long.
    with TemporaryDirectory(dir="/tmp") as folder:
        path = Path(folder) / "mosquitto.sock"
        broker = rig.broker(f"listener 0 {path}")
        wait_until(path.exists, "mosquitto to listen there too")
        transport = rig.started(f"unix://{path}")
        rig.prove(broker)
        broker.kill()
        wait_until(lambda: transport.health.state is TransportState.RECONNECTING, "the loss")
        broker.start()
        rig.prove(broker)


def test_a_retained_message_is_counted_and_not_published(rig: MosquittoRig) -> None:
    broker = rig.broker()
    broker.publish(b"old", "-r")
    transport = rig.started(broker.address)
    rig.prove(broker)
    assert transport.health.frame_errors == {"retained": 1}
    broker.publish(b"new", "-r")
    assert rig.next() == b"new", "it is sent now, and kept for others"


def test_of_a_wildcard_the_first_device_is_read(rig: MosquittoRig) -> None:
    broker = rig.broker()
    transport = rig.started(broker.address, mqtt_topic="sensors/+/data")
    rig.prove(broker, topic="sensors/one/data")
    broker.publish(b"of another", topic="sensors/two/data")
    broker.publish(b"no data", topic="sensors/one/state")
    rig.prove(broker, topic="sensors/one/data")
    assert transport.health.frame_errors == {"other_topic": 1}


def status(broker: Mosquitto) -> bytes:
    """What the broker keeps on the status topic."""
    return broker.kept("imu/status")


def test_the_status_topic_says_online_and_after_close_offline(rig: MosquittoRig) -> None:
    broker = rig.broker()
    transport = rig.started(broker.address, status_topic="imu/status")
    wait_until(lambda: status(broker) == b"online", "online")
    transport.close()
    wait_until(lambda: status(broker) == b"offline", "offline")


def test_the_status_topic_says_offline_when_the_reader_is_killed(rig: MosquittoRig) -> None:
    broker = rig.broker()
    with RunningRosbase(
        "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
        "-p", "status_topic:=imu/status",
    ) as reader:  # fmt: skip
        wait_until(lambda: status(broker) == b"online", "online")
        reader.end(signal.SIGKILL)
    wait_until(lambda: status(broker) == b"offline", "offline")


def test_m12_a_huge_an_empty_and_a_binary_payload_are_counted_or_handed_over(
    rig: MosquittoRig,
) -> None:
    broker = rig.broker()
    transport = rig.started(broker.address)
    rig.prove(broker)
    for payload in (b"x" * 5_000_000, b"", b"\0\r\n", b"\xff\0\xfe"):
        broker.publish(payload)
    assert rig.next() == b"\xff\0\xfe"
    assert transport.health.frame_errors == {"overlong": 1, "empty": 2}


def test_a_flood_comes_through_in_order(rig: MosquittoRig) -> None:
    broker = rig.broker(more="allow_anonymous true\nmax_queued_messages 0")
    rig.started(broker.address, qos=1)
    rig.prove(broker)
    broker.publish_lines([b"%d" % number for number in range(5000)])
    assert [int(rig.next()) for _ in range(5000)] == list(range(5000))
