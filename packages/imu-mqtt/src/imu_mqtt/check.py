"""Checks of the broker for `rosbase doctor`: it accepts the subscription to the topic."""

from collections.abc import Iterable, Mapping

from imu_mqtt.config import PASSWORD_VARIABLE, MqttConfig
from imu_mqtt.connection import Connection
from imu_mqtt.dialing import RefusedError
from rosbase import (
    CheckContext,
    Clock,
    DeviceNotFoundError,
    Finding,
    Outcome,
    ParameterError,
    ParameterValue,
    TransportError,
)

__all__ = ["check_broker"]


def check_broker(context: CheckContext) -> Iterable[Finding]:
    """Connect and subscribe, as a reader would, and leave no trace there."""
    try:
        config = _as_a_guest(context.values)
    except ParameterError as refusal:
        advice = "see `rosbase imu --list-parameters`"
        return [Finding(Outcome.FAIL, str(refusal), advice)]
    error = _try(config, context.clock)
    if error is None:
        text = f"{config.address} accepts the subscription to {config.topic}"
        return [Finding(Outcome.OK, text)]
    if context.asks_for("mqtt", "server_address"):
        return [Finding(Outcome.FAIL, str(error), _advice_on(error, config))]
    if isinstance(error, DeviceNotFoundError):
        advice = "if the broker runs on another host: -p server_address:=tcp://HOST:PORT"
        return [Finding(Outcome.SKIP, f"{error}, the default address", advice)]
    return [Finding(Outcome.WARN, str(error), _advice_on(error, config))]


def _as_a_guest(values: Mapping[str, ParameterValue]) -> MqttConfig:
    """Return the settings with another client name: a broker disconnects a second one."""
    client_id = f"{values['client_id']}-doctor" if values["client_id"] else ""
    return MqttConfig.from_values({**values, "client_id": client_id, "status_topic": ""})


def _try(config: MqttConfig, clock: Clock) -> TransportError | None:
    """Connect and subscribe, and return the reason if that fails."""
    try:
        connection = Connection(config, clock, lambda message: None, lambda: True)
    except TransportError as error:
        return error
    try:
        connection.open()
        connection.subscribe()
    except TransportError as error:
        return error
    finally:
        connection.close()
    return None


def _advice_on(error: TransportError, config: MqttConfig) -> str:
    match error:
        case DeviceNotFoundError():
            return (
                "start the broker, or set its address: -p server_address:=tcp://HOST:PORT;"
                " is there a firewall?"
            )
        case RefusedError(advice=advice) if advice:
            return advice
        case RefusedError():
            who = f"as {config.username!r}" if config.username else "without a username"
            return (
                f"the reader connects {who}: set username, and the password in"
                f" {PASSWORD_VARIABLE} or password_file;"
                " check the users and the topic permissions of the broker"
            )
    return "see the broker's log; is it an MQTT broker?"
