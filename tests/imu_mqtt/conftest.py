"""What the tests of the transport have in common."""

from collections.abc import Iterator

import pytest

from imu_mqtt.simulator import EmbeddedBroker
from support.mqtt import Publisher, ScriptedBroker
from support.mqtt_rig import MqttRig


@pytest.fixture
def rig() -> Iterator[MqttRig]:
    rig = MqttRig()
    yield rig
    for transport in rig.made:
        transport.close()


@pytest.fixture
def broker() -> Iterator[ScriptedBroker]:
    with ScriptedBroker() as broker:
        yield broker


@pytest.fixture
def embedded() -> Iterator[EmbeddedBroker]:
    broker = EmbeddedBroker()
    yield broker
    broker.close()


@pytest.fixture
def publisher(embedded: EmbeddedBroker) -> Iterator[Publisher]:
    with Publisher(embedded.port) as publisher:
        yield publisher
