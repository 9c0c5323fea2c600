"""What `rosbase doctor` says of the broker."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from imu_mqtt import connection
from imu_mqtt.check import check_broker
from imu_mqtt.config import PARAMETERS, PASSWORD_VARIABLE
from imu_mqtt.simulator import EmbeddedBroker
from rosbase.clock import SystemClock
from rosbase.contracts.checks import CheckContext, Finding, Outcome
from rosbase.parameters import ParameterValue
from support.certificates import Authority
from support.mosquitto import Mosquitto, free_port, is_installed, set_password
from support.mosquitto_rig import MosquittoRig
from support.mqtt import ScriptedBroker, refuses, says_nothing
from support.mqtt_rig import elapsed

needs_mosquitto = pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")
DEFAULTS = {"comm_t": "serial", **{spec.name: spec.default for spec in PARAMETERS}}


def finding(**given: ParameterValue) -> Finding:
    (found,) = check_broker(CheckContext(SystemClock(), DEFAULTS | given, frozenset(given)))
    return found


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[MosquittoRig]:
    rig = MosquittoRig(tmp_path)
    yield rig
    rig.close()


@pytest.fixture
def guarded(tmp_path: Path) -> Iterator[Mosquitto]:
    """A broker that lets in `imu`, whose password is `right`."""
    set_password(tmp_path / "passwords", "imu", "right")
    more = f"allow_anonymous false\npassword_file {tmp_path / 'passwords'}"
    broker = Mosquitto(tmp_path, more=more)
    yield broker
    broker.stop()


def test_a_broker_that_is_there_and_lets_us_read_is_fine(embedded: EmbeddedBroker) -> None:
    assert finding(server_address=embedded.address) == Finding(
        Outcome.OK, f"{embedded.address} accepts the subscription to esp32/imu"
    )


def test_a_broker_that_is_asked_for_and_absent_fails() -> None:
    address = f"tcp://127.0.0.1:{free_port()}"
    found = finding(server_address=address)
    assert (found.outcome, found.text) == (Outcome.FAIL, f"there is no broker at {address}")
    assert "start the broker" in found.advice


def test_a_broker_that_nobody_has_asked_for_may_be_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(DEFAULTS, "server_address", f"tcp://127.0.0.1:{free_port()}")
    found = finding()
    assert found.outcome is Outcome.SKIP
    assert "-p server_address:=" in found.advice
    assert finding(comm_t="mqtt").outcome is Outcome.FAIL


def test_a_broker_that_nobody_has_asked_for_and_refuses_is_a_warning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with ScriptedBroker(refuses(5)) as broker:
        monkeypatch.setitem(DEFAULTS, "server_address", broker.address)
        assert finding().outcome is Outcome.WARN


@needs_mosquitto
def test_a_wrong_password_fails_and_is_not_told(
    guarded: Mosquitto, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PASSWORD_VARIABLE, "hush")
    nobody = finding(server_address=guarded.address)
    wrong = finding(server_address=guarded.address, username="imu")
    monkeypatch.setenv(PASSWORD_VARIABLE, "right")
    right = finding(server_address=guarded.address, username="imu")
    assert [f.outcome for f in (nobody, wrong, right)] == [
        Outcome.FAIL,
        Outcome.FAIL,
        Outcome.OK,
    ]
    assert wrong.text == f"{guarded.address} refuses the connection as 'imu': Not authorized"
    assert "without a username" in nobody.advice
    assert "as 'imu'" in wrong.advice
    assert PASSWORD_VARIABLE in wrong.advice
    assert "hush" not in wrong.text + wrong.advice


@needs_mosquitto
def test_a_certificate_that_nobody_here_trusts_fails_with_what_to_trust(
    rig: MosquittoRig,
) -> None:
    certificate, key = Authority(rig.folder, "authority").sign("server", host="DNS:localhost")
    broker = rig.broker(f"certfile {certificate}", f"keyfile {key}")
    address = f"mqtts://localhost:{broker.port}"
    untrusted = finding(server_address=address)
    assert untrusted.outcome is Outcome.FAIL
    assert "TLS fails" in untrusted.text
    assert "tls_ca_file" in untrusted.advice
    trusted = finding(server_address=address, tls_ca_file=str(rig.folder / "authority.pem"))
    assert trusted.outcome is Outcome.OK


@needs_mosquitto
def test_what_is_advised_on_tls_is_what_is_wrong(rig: MosquittoRig) -> None:
    authority = Authority(rig.folder, "authority")
    certificate, key = authority.sign("server", host="DNS:localhost")
    ca = str(authority.file)
    settings = (f"certfile {certificate}", f"keyfile {key}", f"cafile {ca}")
    broker = rig.broker(*settings, "require_certificate true")
    secure, by_number = f"mqtts://localhost:{broker.port}", f"mqtts://127.0.0.1:{broker.port}"
    trusted = {"tls_ca_file": ca}
    assert "a name in the broker's certificate" in (
        finding(server_address=by_number, **trusted).advice
    )
    mine = {"tls_cert_file": str(certificate), "tls_key_file": str(rig.folder / "none")}
    assert "PEM files" in finding(server_address=secure, **trusted, **mine).advice
    refused = finding(server_address=secure, **trusted)
    # The broker says why and hangs up, and the network may lose the one over the other.
    assert "tls_cert_file" in refused.advice or "ended the TLS handshake" in refused.text
    broker.stop()
    plain = rig.broker()
    assert "use tcp://" in finding(server_address=f"mqtts://localhost:{plain.port}").text


def test_what_speaks_no_mqtt_is_no_matter_of_passwords() -> None:
    with ScriptedBroker(lambda peer: peer.send(b"HTTP/1.1 400 Bad Request\r\n\r\n")) as web:
        found = finding(server_address=web.address)
    assert "ws://" in found.advice or "is it one for MQTT?" in found.advice


@pytest.mark.parametrize(
    ("given", "password", "text"),
    [
        ({"username": "imu"}, "", "refuses the connection as 'imu' without a password: "),
        (
            {},
            "right",
            f"refuses the connection without a username, which {PASSWORD_VARIABLE} needs: ",
        ),
        ({}, "", "refuses the connection: "),
    ],
)
def test_a_refusal_says_as_whom_we_came(
    monkeypatch: pytest.MonkeyPatch, given: dict[str, str], password: str, text: str
) -> None:
    if password:
        monkeypatch.setenv(PASSWORD_VARIABLE, password)
    with ScriptedBroker(refuses(5)) as broker:
        assert text in finding(server_address=broker.address, **given).text


def test_a_broker_for_an_older_version_is_thought_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "ANSWER_TIMEOUT_S", 0.2)
    with ScriptedBroker(says_nothing) as broker:
        found = finding(server_address=broker.address, mqtt_version="5")
    assert found.text.endswith("; does it speak MQTT 5?")


@needs_mosquitto
def test_a_reader_that_is_connected_is_not_disturbed(rig: MosquittoRig) -> None:
    broker = rig.broker()
    own = {"client_id": "imu", "status_topic": "imu/status"}
    transport = rig.started(broker.address, **own)
    rig.prove(broker)
    assert finding(server_address=broker.address, **own).outcome is Outcome.OK
    rig.prove(broker)
    assert transport.health.reconnects == 0
    assert broker.kept("imu/status") == b"online"


def test_values_that_contradict_each_other_fail_in_one_line() -> None:
    found = finding(server_address="tcp://a:b@host")
    assert found.outcome is Outcome.FAIL
    assert "must not contain a user or a password" in found.text
    assert found.advice


def test_a_broker_that_says_nothing_fails_in_bounded_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "ANSWER_TIMEOUT_S", 0.2)
    with ScriptedBroker(says_nothing) as broker:
        took_s = elapsed(lambda: finding(server_address=broker.address))
        assert took_s < 2.0
        assert finding(server_address=broker.address).outcome is Outcome.FAIL
