"""M3: a broker that is there, and does not want us as we are."""

import itertools

import pytest

from imu_mqtt import network_thread
from imu_mqtt.dialing import RefusedError
from rosbase.contracts.transport import TransportState
from rosbase.runtime.backoff import Backoff
from support.mqtt import (
    GOOD,
    Peer,
    ScriptedBroker,
    ends_after_connack,
    refuses,
    refuses_subscriptions,
    sends,
    serves,
)
from support.mqtt_rig import MqttRig, elapsed, wait_for_state, warnings
from support.waiting import wait_until


@pytest.mark.parametrize("code", [1, 2, 4, 5])
def test_m3_a_refusal_is_named_and_raised(rig: MqttRig, broker: ScriptedBroker, code: int) -> None:
    broker.behaviour = refuses(code)
    transport = rig.transport(broker.address)
    with pytest.raises(
        RefusedError, match=f"^{broker.address} (refuses the connection: |does not speak MQTT)"
    ) as caught:
        transport.open()
    assert "\n" not in str(caught.value)
    assert broker.dials == 1


def test_m3_who_is_refused_tries_slowly_and_comes_in_when_the_cause_goes(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    broker.behaviour = refuses(5)
    transport = rig.transport(broker.address, wait_for_broker=True)
    transport.open()
    transport.start(rig.keep)
    broker.behaviour = sends(GOOD)
    assert elapsed(lambda: rig.frames.get(timeout=20)) > 1.0
    assert broker.dials == 2
    assert len(warnings(caplog)) == 1, "one line, not one per try"


def test_m3_a_broker_that_is_not_ready_yet_is_tried_again_soon(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    broker.behaviour = refuses(3)
    transport = rig.started(broker.address, wait_for_broker=True)
    wait_until(lambda: broker.dials > 1, "another try", timeout_s=1.0)
    broker.behaviour = serves
    assert elapsed(lambda: wait_for_state(transport, TransportState.CONNECTED)) < 2.0


def test_m3_a_subscription_that_is_refused_is_named_to_whoever_starts_it_and_nowhere_else(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    broker.behaviour = refuses_subscriptions
    transport = rig.transport(broker.address)
    for _ in range(3):
        transport.open()
        with pytest.raises(RefusedError, match="refuses the subscription to esp32/imu"):
            transport.start(rig.keep)
        assert "refuses the subscription" in transport.health.last_error
        transport.close()
    assert warnings(caplog) == []


def test_m3_a_subscription_that_is_refused_is_waited_for_by_option(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    broker.behaviour = refuses_subscriptions
    transport = rig.started(broker.address, wait_for_broker=True)
    wait_until(lambda: warnings(caplog), "the reason")
    assert not transport.is_open
    broker.behaviour = sends(GOOD)
    assert rig.next() == b"good"
    assert transport.health.last_error == ""
    (line,) = warnings(caplog)
    assert "refuses the subscription to esp32/imu" in line


def test_m3_a_subscription_that_is_refused_after_a_loss_is_one_line_until_it_is_allowed(
    rig: MqttRig,
    broker: ScriptedBroker,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(network_thread, "_SLOW_S", 0.1)
    caplog.set_level("INFO", logger="rosbase")
    transport = rig.started(broker.address)
    broker.behaviour = refuses_subscriptions
    broker.drop()
    wait_until(lambda: broker.dials > 5, "some tries")
    assert transport.health.state is TransportState.RECONNECTING
    assert transport.health.reconnects == 0
    said = caplog.messages[1:]
    assert len(said) == 2, "it was lost; it is refused"
    broker.behaviour = sends(GOOD)
    assert rig.next() == b"good"
    assert transport.health.reconnects == 1
    assert caplog.messages[3:] == [f"back at {broker.address}"]


def test_m3_a_broker_that_fails_in_turns_is_told_of_a_few_times_and_not_for_ever(
    rig: MqttRig,
    broker: ScriptedBroker,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Backoff, "next_s", lambda self: 0.01)
    caplog.set_level("INFO", logger="rosbase")
    turns = itertools.cycle([ends_after_connack, refuses(3)])

    def fails_in_turns(peer: Peer) -> None:
        next(turns)(peer)

    broker.behaviour = fails_in_turns
    rig.started(broker.address, wait_for_broker=True)
    wait_until(lambda: broker.dials > 20, "many tries")
    assert len(caplog.messages) < 12


def test_m3_a_broker_that_hangs_up_on_the_subscription_is_named(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    def hangs_up(peer: Peer) -> None:
        peer.accept()
        peer.receive()

    broker.behaviour = hangs_up
    transport = rig.started(broker.address)
    named = "at the subscription to esp32/imu"
    wait_until(lambda: named in transport.health.last_error, "the reason")


def test_m3_two_clients_with_one_id_are_named_and_do_not_fight_on_for_ever(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    broker.behaviour = ends_after_connack
    transport = rig.started(broker.address, client_id="imu")
    question = "is there another client 'imu', or a broker that restarts?"
    wait_until(lambda: question in transport.health.last_error, "the named fault")
    dials = broker.dials
    assert elapsed(lambda: wait_until(lambda: broker.dials > dials, "another try")) > 0.5
    assert sum(question in message for message in caplog.messages) == 1
    said = len(caplog.messages)
    broker.behaviour = sends(GOOD)
    assert rig.next() == b"good"
    assert len(caplog.messages) == said, "nothing new yet: the other may come back"
