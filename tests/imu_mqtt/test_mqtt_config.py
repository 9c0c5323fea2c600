"""Addresses, topics and passwords: what is taken, and what is said of the rest."""

import logging
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from imu_mqtt.config import PASSWORD_VARIABLE, Address
from imu_mqtt.dialing import RefusedError
from rosbase.errors import ParameterError, TransportError
from support.mqtt import ScriptedBroker, packet, refuses
from support.mqtt_rig import MqttRig, config
from support.strategies import mqtt_secrets

SECRET = "s3cr&t"


def complaint(**changes: Any) -> str:
    """What is wrong with these parameters."""
    with pytest.raises(ParameterError) as caught:
        config(**changes)
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("tcp://localhost:1883", "tcp://localhost:1883"),
        ("mqtt://broker", "mqtt://broker:1883"),
        ("mqtts://broker", "mqtts://broker:8883"),
        ("MQTTS://Broker:1", "mqtts://broker:1"),
        ("ws://broker", "ws://broker:80"),
        ("wss://broker/somewhere", "wss://broker:443"),
        ("tcp://[::1]", "tcp://[::1]:1883"),
        ("unix:///run/mosquitto@home.sock", "unix:///run/mosquitto@home.sock"),
    ],
)
def test_an_address_is_a_scheme_a_host_and_a_port_that_may_be_left_out(
    text: str, shown: str
) -> None:
    assert str(Address.parse(text)) == shown


def test_a_websocket_has_a_path() -> None:
    assert Address.parse("ws://broker").path == "/mqtt"
    assert Address.parse("ws://broker/a/b").path == "/a/b"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "localhost",
        "localhost:1883",
        "http://localhost",
        "tcp://",
        "tcp://:1883",
        "tcp://host:0",
        "tcp://host:65536",
        "tcp://host:port",
        "tcp://[::1",
        "tcp://host/path",
        "tcp://ho st",
        "tcp://host\n",
        "tcp://host\0",
        "ws://host/path?query",
        "unix://run/socket",
        "unix://",
        "unix:///run/a#b",
    ],
)
def test_what_is_no_address_is_one_line(text: str) -> None:
    assert complaint(address=text).startswith("parameter server_address ")


@pytest.mark.parametrize("port", ["0", "-1", "65536", "port"])
def test_what_is_no_port_is_named(port: str) -> None:
    assert "takes a port from 1 to 65535" in complaint(address=f"tcp://host:{port}")


@given(
    st.text(max_size=30) | st.builds("{}://{}".format, st.sampled_from(["tcp", "ws"]), st.text())
)
def test_any_text_is_an_address_that_reads_back_or_a_complaint(text: str) -> None:
    try:
        address = Address.parse(text)
    except ParameterError:
        complaint(address=text)
    else:
        again = Address.parse(str(address))
        assert (again.scheme, again.host, again.port) == (
            address.scheme,
            address.host,
            address.port,
        )


@given(mqtt_secrets)
def test_no_complaint_about_an_address_says_the_password_in_it(secret: str) -> None:
    # What would be said of any password.
    assume(secret not in complaint(address="tcp://a:b@host"))
    for text in (f"tcp://me:{secret}@host", f"tcp://{secret}@host:1", f"//me:{secret}@host:x"):
        said = complaint(address=text)
        assert PASSWORD_VARIABLE in said
        assert secret not in said


@pytest.mark.parametrize("topic", ["a", "/", "a//b", "+", "#", "a/+/b/#", "+/imu", "µ/imu"])
def test_topics_and_filters_are_taken(topic: str) -> None:
    assert config(mqtt_topic=topic).is_filter == bool({"+", "#"} & set(topic))


@pytest.mark.parametrize(
    "topic", ["", "a\0", "a+/b", "#/a", "a#", "a/#/b", "a\n", "x" * 65_536, "\udcff", "é" * 40_000]
)
def test_what_is_no_topic_is_one_line(topic: str) -> None:
    assert complaint(mqtt_topic=topic).startswith("parameter mqtt_topic")


@pytest.mark.parametrize("topic", ["+", "a/#"])
def test_a_status_has_one_topic(topic: str) -> None:
    assert "status_topic takes one topic" in complaint(status_topic=topic)


@pytest.mark.parametrize("topic", ["$SYS/state", "$share/group/state"])
def test_a_status_is_not_sent_to_a_topic_of_the_brokers_own(topic: str) -> None:
    assert "must not start with $" in complaint(status_topic=topic)


@given(st.text())
def test_any_text_is_a_topic_or_a_complaint(topic: str) -> None:
    try:
        assert config(mqtt_topic=topic).topic == topic
    except ParameterError:
        complaint(mqtt_topic=topic)


@pytest.mark.parametrize(
    ("read", "status"),
    [("a/b", "a/b"), ("a/+", "a/b"), ("#", "a"), ("a/#", "a"), ("a/#", "a/b/c"), ("+/+", "a/b")],
)
def test_a_status_topic_that_would_be_read_as_the_device_is_refused(read: str, status: str) -> None:
    assert "matches mqtt_topic" in complaint(mqtt_topic=read, status_topic=status)


@pytest.mark.parametrize(
    ("read", "status"), [("a/b", "a"), ("a/+", "a/b/c"), ("+", "a/b"), ("a/+/c", "a/b/d")]
)
def test_a_status_topic_beside_the_devices_is_fine(read: str, status: str) -> None:
    assert config(mqtt_topic=read, status_topic=status).status_topic == status


def test_a_tilde_stands_for_the_users_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/me")
    files = {"tls_ca_file": "~/ca.pem", "password_file": "~/password"}
    made = config(address="mqtts://host", username="me", **files)
    assert (made.ca_file, made.password_file) == ("/home/me/ca.pem", "/home/me/password")


@pytest.mark.parametrize("name", ["client_id", "username", "status_topic"])
@pytest.mark.parametrize("text", ["x" * 65_536, "\0", "\udcff", "a\nb", "a\x9f"])
def test_what_mqtt_cannot_carry_is_said_before_anything_is_dialled(name: str, text: str) -> None:
    assert name in complaint(**{name: text})


def test_settings_that_belong_together_are_asked_for_together() -> None:
    assert "tls_key_file needs tls_cert_file" in complaint(
        address="mqtts://host", tls_key_file="key.pem"
    )
    assert "not a secure address" in complaint(tls_ca_file="ca.pem")
    assert "password_file needs username" in complaint(password_file="password")


def test_each_client_has_an_id_of_its_own_unless_it_is_given_one() -> None:
    assert config().client_id != config().client_id
    assert config(client_id="imu").client_id == "imu"


def test_the_password_comes_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = config(username="me")
    assert settings.read_password() is None
    monkeypatch.setenv(PASSWORD_VARIABLE, SECRET)
    assert settings.read_password() == SECRET


def test_a_file_goes_before_the_environment_and_is_read_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "password"
    monkeypatch.setenv(PASSWORD_VARIABLE, "another")
    settings = config(username="me", password_file=str(file))
    for written, read in ((f"{SECRET}\n", SECRET), (" with blanks ", " with blanks ")):
        file.write_text(written)
        assert settings.read_password() == read


@pytest.mark.parametrize(
    "what", ["absent", "folder", "name", "bytes", "long", "zero", "empty", "pipe"]
)
def test_a_password_that_cannot_be_read_is_one_line_without_it(tmp_path: Path, what: str) -> None:
    file = tmp_path / "password"
    contents = {"bytes": SECRET.encode() + b"\xff", "long": SECRET.encode() * 20_000}
    contents |= {"zero": SECRET.encode() + b"\0", "empty": b"\n"}
    if what == "pipe":
        os.mkfifo(file)
    if what in contents:
        file.write_bytes(contents[what])
    names = {"folder": str(tmp_path), "name": "a\0b"}
    settings = config(username="me", password_file=names.get(what, str(file)))
    with pytest.raises(TransportError, match=r"^password_file ") as caught:
        settings.read_password()
    assert str(caught.value).isprintable()
    assert SECRET not in str(caught.value)


def test_a_password_that_is_no_text_is_refused_without_a_word_of_it(
    rig: MqttRig,
    broker: ScriptedBroker,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setenv(PASSWORD_VARIABLE, f"{SECRET}\udcff")
    transport = rig.transport(broker.address, username="me", wait_for_broker=True)
    transport.open()
    assert PASSWORD_VARIABLE in transport.health.last_error
    assert SECRET not in caplog.text


def test_the_password_goes_to_the_broker_and_nowhere_else(
    rig: MqttRig,
    broker: ScriptedBroker,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.DEBUG)
    (tmp_path / "password").write_text(f"{SECRET}\n")
    greetings: list[bytes] = []

    def refuse(peer: Any) -> None:
        greetings.append(peer.receive()[1])
        peer.send(packet(0x20, b"\0\5"))

    broker.behaviour = refuse
    transport = rig.transport(
        broker.address, username="me", password_file=str(tmp_path / "password")
    )
    with pytest.raises(RefusedError) as caught:
        transport.open()
    assert greetings[0].endswith(b"\0\2me\0\6" + SECRET.encode())
    shown = [caplog.text, str(caught.value), repr(transport._config), repr(transport.health)]
    assert SECRET not in "".join(shown)


def test_a_password_that_changes_is_used_at_the_next_try(
    rig: MqttRig, broker: ScriptedBroker, monkeypatch: pytest.MonkeyPatch
) -> None:
    broker.behaviour = refuses(4)
    transport = rig.transport(broker.address, username="me")
    for password in ("wrong", "right"):
        monkeypatch.setenv(PASSWORD_VARIABLE, password)
        greetings: list[bytes] = []

        def check(peer: Any, greetings: list[bytes] = greetings) -> None:
            greetings.append(peer.receive()[1])
            peer.send(packet(0x20, b"\0" + (b"\0" if greetings[0].endswith(b"right") else b"\4")))
            peer.serve()

        broker.behaviour = check
        if password == "wrong":
            with pytest.raises(RefusedError, match="user name or password"):
                transport.open()
        else:
            transport.open()
    assert transport.is_open


@pytest.mark.parametrize("name", ["absent.pem", "", "a\0b"])
def test_certificates_that_cannot_be_used_are_one_line(
    rig: MqttRig, tmp_path: Path, name: str
) -> None:
    (tmp_path / "empty.pem").touch()
    path = str(tmp_path / (name or "empty.pem"))
    for parameter in ("tls_ca_file", "tls_cert_file"):
        transport = rig.transport("mqtts://127.0.0.1:1", **{parameter: path})
        with pytest.raises(RefusedError, match="cannot be used for TLS") as caught:
            transport.open()
        assert "\n" not in str(caught.value)


def test_of_the_files_for_tls_the_one_that_cannot_be_used_is_named(rig: MqttRig) -> None:
    ours = {"tls_cert_file": "ours.pem", "tls_key_file": "ours.key"}
    transport = rig.transport("mqtts://127.0.0.1:1", tls_ca_file="absent.pem", **ours)
    with pytest.raises(RefusedError, match=r"^absent\.pem cannot be used"):
        transport.open()
    transport = rig.transport("mqtts://127.0.0.1:1", **ours)
    with pytest.raises(RefusedError, match=r"^ours\.pem, ours\.key cannot be used"):
        transport.open()
