"""What the package brings into rosbase: a transport, two presets, a simulated device."""

import json
import subprocess
import sys
import threading
from typing import Any

import pytest

from imu_mqtt.simulator import BrokeredDevice
from rosbase.errors import TransportError
from rosbase.imu.settings import reader_parameters
from rosbase.plugins import installed_plugins
from support.mqtt_rig import MqttRig, elapsed
from support.reader_rig import Rig

LIST = """
import sys
from rosbase.cli import main
main(["plugins"])
assert not {"paho", "amqtt", "ssl", "imu_mqtt.connection"} & set(sys.modules), "imported too much"
"""

DEMO_WITHOUT_BROKER = """
import sys
sys.modules["amqtt"] = None
from rosbase.cli import main
sys.exit(main(["demo", "--transport", "mqtt", "--duration", "1"]))
"""

WORKSHOP = {
    "accX": 0.5,
    "accY": -0.25,
    "accZ": 9.75,
    "gycX": 0.125,
    "gycY": -1,
    "gycZ": 0,
    "temp": 24.5,
    "timestamp": "2025-10-01T12:00:00",
}
CJSON = {"Ax": 0.5, "Ay": -1, "Az": 1.0, "Temperature": 24.5, "Gx": 90.0, "Gy": -180, "Gz": 0.5}
G = 9.80665


def run_python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=False
    )


def layouts(payload: dict[str, Any]) -> list[bytes]:
    """The payload in one line, and over many as cJSON prints it."""
    members = ",\r\n".join(f"\t{json.dumps(key)}:\t{json.dumps(payload[key])}" for key in payload)
    return [json.dumps(payload).encode(), f"{{\r\n{members}\r\n}}".encode()]


def test_the_transport_and_its_presets_are_found_under_their_names() -> None:
    registry = installed_plugins()
    (record,) = [r for r in registry.plugins if r.distribution == "imu-mqtt"]
    assert (record.failure, record.name) == ("", "mqtt")
    assert registry.transport("mqtt").summary == "payloads from an MQTT broker"
    assert {"esp32_workshop", "esp32_cjson"} <= set(registry.presets)


def test_listing_plugins_imports_no_network_library() -> None:
    shown = run_python(LIST)
    assert shown.returncode == 0, shown.stderr
    assert "transport: mqtt" in shown.stdout


def test_the_parameters_have_the_defaults_of_the_first_reader() -> None:
    defaults = {spec.name: spec.default for spec in reader_parameters(installed_plugins())}
    assert defaults["server_address"] == "tcp://localhost:1883"
    assert defaults["mqtt_topic"] == "esp32/imu"
    assert defaults["wait_for_broker"] is False


def test_no_parameter_takes_a_password() -> None:
    names = {spec.name for spec in installed_plugins().transport("mqtt").parameters}
    assert {name for name in names if "password" in name} == {"password_file"}


@pytest.mark.parametrize("layout", [0, 1], ids=["one line", "many lines"])
@pytest.mark.parametrize("timestamp", ["2025-10-01T12:00:00", "N/A"])
def test_preset_esp32_workshop_reads_si_units_whatever_the_time_is(
    layout: int, timestamp: str
) -> None:
    rig = Rig(preset="esp32_workshop").activate()
    frame = layouts({**WORKSHOP, "timestamp": timestamp})[layout]
    ((topic, message), *_) = rig.send(frame, 1_500_000_000)
    assert topic == "data_raw", "without orientation"
    acceleration, velocity = message.linear_acceleration, message.angular_velocity
    assert (acceleration.x, acceleration.y, acceleration.z) == (0.5, -0.25, 9.75)
    assert (velocity.x, velocity.y, velocity.z) == (0.125, -1.0, 0.0)
    assert message.orientation_covariance[0] == -1.0
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)


@pytest.mark.parametrize("layout", [0, 1], ids=["one line", "many lines"])
def test_preset_esp32_cjson_makes_si_units_of_g_and_degrees(layout: int) -> None:
    rig = Rig(preset="esp32_cjson").activate()
    ((topic, message), *_) = rig.send(layouts(CJSON)[layout])
    assert topic == "data_raw", "without orientation"
    acceleration, velocity = message.linear_acceleration, message.angular_velocity
    assert (acceleration.x, acceleration.y, acceleration.z) == pytest.approx((G / 2, -G, G))
    pi = 3.141592653589793
    assert (velocity.x, velocity.y, velocity.z) == pytest.approx((pi / 2, -pi, pi / 360))
    assert message.orientation_covariance[0] == -1.0


def test_a_demo_without_a_broker_says_in_one_line_what_to_install() -> None:
    shown = run_python(DEMO_WITHOUT_BROKER)
    assert shown.returncode == 2
    assert shown.stdout == ""
    (line,) = shown.stderr.splitlines()
    assert "pip install 'amqtt>=0.11'" in line


def test_what_the_simulated_device_sends_arrives_in_order(rig: MqttRig) -> None:
    device = BrokeredDevice()
    settings: dict[str, Any] = dict(device.parameters)
    rig.started(settings.pop("server_address"), **settings)
    for number in range(200):
        device.send(b"%d" % number)
    assert [int(rig.next()) for _ in range(200)] == list(range(200))
    rig.made[0].close()
    device.close()
    device.close()


def test_closing_the_simulated_device_ends_a_send_that_waits() -> None:
    device = BrokeredDevice()
    ended: list[str] = []

    def fill() -> None:
        try:
            while True:
                device.send(b"x" * 60_000)
        except TransportError as error:
            ended.append(str(error))

    thread = threading.Thread(target=fill)
    thread.start()
    assert elapsed(device.close) < 3.0
    thread.join(10)
    assert len(ended) == 1
    with pytest.raises(TransportError, match="closed"):
        device.send(b"x")
