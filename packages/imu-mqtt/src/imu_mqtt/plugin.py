"""Register the transport `mqtt`, presets and a check. Imports no network library."""

from collections.abc import Iterable, Mapping

from imu_mqtt.config import PARAMETERS, MqttConfig
from rosbase import (
    CheckContext,
    CheckPlugin,
    Finding,
    ParameterValue,
    PresetPlugin,
    SimulatedDevice,
    Transport,
    TransportContext,
    TransportPlugin,
    hookimpl,
)

__all__ = ["rosbase_checks", "rosbase_presets", "rosbase_transports"]

_WRONG_TOPIC = "is it the right topic?"
_HINTS = {
    "no_imu_data": _WRONG_TOPIC,
    "not_data": _WRONG_TOPIC,
    "not_utf8": _WRONG_TOPIC,
    "overlong": _WRONG_TOPIC,
}


def _create(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    from imu_mqtt.transport import MqttTransport

    return MqttTransport(MqttConfig.from_values(values), context)


def _simulate() -> SimulatedDevice:
    from imu_mqtt.simulator import BrokeredDevice

    return BrokeredDevice()


def _check(context: CheckContext) -> Iterable[Finding]:
    from imu_mqtt.check import check_broker

    return check_broker(context)


@hookimpl
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Register payloads from a topic of a broker."""
    yield TransportPlugin(
        "mqtt",
        "payloads from an MQTT broker",
        _create,
        parameters=PARAMETERS,
        simulate=_simulate,
        hints=_HINTS,
    )


@hookimpl
def rosbase_presets() -> Iterable[PresetPlugin]:
    """Register the payloads of firmware that uses MQTT."""
    yield PresetPlugin(
        "esp32_workshop",
        "ESP32 with an MPU6050 that sends accX .. gycZ in m/s^2 and rad/s, and a local time",
        {
            "angular_velocity.paths": ["gycX", "gycY", "gycZ"],
            "angular_velocity.unit": "rad/s",
            "linear_acceleration.paths": ["accX", "accY", "accZ"],
            "linear_acceleration.unit": "m/s^2",
            "time.paths": ["timestamp"],
            "time.unit": "s",
            "required": ["angular_velocity", "linear_acceleration"],
        },
    )
    yield PresetPlugin(
        "esp32_cjson",
        "ESP32 that prints Ax .. Gz with cJSON, in g and deg/s",
        {
            "angular_velocity.paths": ["Gx", "Gy", "Gz"],
            "angular_velocity.unit": "deg/s",
            "linear_acceleration.paths": ["Ax", "Ay", "Az"],
            "linear_acceleration.unit": "g",
            "required": ["angular_velocity", "linear_acceleration"],
        },
    )


@hookimpl
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Register the check of the broker."""
    yield CheckPlugin("mqtt", "the broker: connection, login and subscription", _check)
