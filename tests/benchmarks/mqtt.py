"""The reader over MQTT beside a bare paho consumer, through mosquitto: CPU per message, and losses.

`nox -s bench` runs it and prints a table; without mosquitto it says so. Broker, publisher and
consumer are three processes. The rows take turns, and the medians of the turns count; of the
ratio, that of the turn's own.

- bare: paho alone, `loop_forever`, with `json.loads` in `on_message`
- rosbase: `ImuReader` on the local backend, with one subscriber on another thread

Its argument is how long a turn lasts, in seconds.
"""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion

from rosbase.imu.simulator import payload_at
from rosbase.messages import Imu, Time
from support.mosquitto import TOPIC, Mosquitto, is_installed

TURNS = 3
RATE_HZ, TURN_S = 2000, 30.0
# Messages at a time. The broker keeps a hundred of QoS 1 for one client, and drops the others.
BURST = 4
PATIENCE_S = 10.0


def read_bare(port: int, qos: int, wanted: int) -> int:
    """What a hand-written consumer does: no checks, and nobody gets anything."""
    count = 0

    def got(client: mqtt.Client, data: object, message: mqtt.MQTTMessage) -> None:
        nonlocal count
        json.loads(message.payload)
        count += 1
        if count == wanted:
            client.disconnect()

    client = mqtt.Client(CallbackAPIVersion.VERSION2)
    client.on_message = got
    client.on_subscribe = lambda *_: print("ready", flush=True)
    client.connect("127.0.0.1", port)
    # It goes out behind the greeting.
    client.subscribe(TOPIC, qos)
    client.loop_forever()
    return count


def read_rosbase(port: int, qos: int, wanted: int) -> int:
    from rosbase.contracts.backend import BackendOptions
    from rosbase.imu.reader import ImuReader
    from rosbase.local import LocalBackend

    count = 0

    def got(message: Imu) -> None:
        nonlocal count
        count += 1

    address = f"tcp://127.0.0.1:{port}"
    parameters: dict[str, str | int] = {
        "comm_t": "mqtt",
        "server_address": address,
        "mqtt_topic": TOPIC,
        "qos": qos,
    }
    backend = LocalBackend(BackendOptions("bench", parameters))
    reader = ImuReader(backend=backend)
    backend.create_subscription(Imu, "imu/data", got, wanted)
    reader.trigger_configure()
    reader.trigger_activate()
    print("ready", flush=True)
    backend.spin_until(time.monotonic_ns() + 600 * 10**9, lambda: count >= wanted)
    reader.trigger_shutdown()
    backend.close()
    return count


READERS: dict[str, Callable[[int, int, int], int]] = {"bare": read_bare, "rosbase": read_rosbase}


def consume(name: str, port: int, qos: int, wanted: int) -> None:
    """Reads, and prints how many came and what that cost."""
    before = resource.getrusage(resource.RUSAGE_SELF)
    count = READERS[name](port, qos, wanted)
    after = resource.getrusage(resource.RUSAGE_SELF)
    print(count, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, flush=True)


def publish(port: int, qos: int, count: int) -> None:
    """Sends at the rate, several messages for each wake-up."""
    client = mqtt.Client(CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", port)
    client.loop_start()
    payloads = [payload_at(n / 1000, Time(1, n)) for n in range(1000)]
    start = time.monotonic()
    for number in range(count):
        if number % BURST == 0:
            time.sleep(max(0.0, start + number / RATE_HZ - time.monotonic()))
        sent = client.publish(TOPIC, payloads[number % 1000], qos)
    sent.wait_for_publish(PATIENCE_S)
    client.disconnect()
    client.loop_stop()


def measure(name: str, qos: int, count: int) -> tuple[float, int]:
    """Microseconds of CPU per message, and how many were lost, of one turn."""
    with tempfile.TemporaryDirectory() as folder:
        broker = Mosquitto(Path(folder))
        arguments = [str(broker.port), str(qos), str(count)]
        with subprocess.Popen(
            [sys.executable, __file__, name, *arguments], stdout=subprocess.PIPE, text=True
        ) as reader:
            assert reader.stdout is not None
            reader.stdout.readline()
            subprocess.run([sys.executable, __file__, "publish", *arguments], check=True)
            # Whoever has lost messages waits for them, until there is no broker.
            try:
                reader.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                reader.kill()
            broker.stop()
            words = reader.stdout.readline().split()
        assert words, f"{name} has lost messages with QoS {qos}"
        return float(words[1]) / count * 1e6, count - int(words[0])


def main(turn_s: float) -> None:
    """Prints the table."""
    print(f"{'':16}{'us CPU/message':>16}{'of bare':>10}{'lost':>7}")
    for qos in (0, 1):
        turns = [
            {name: measure(name, qos, int(RATE_HZ * turn_s)) for name in READERS}
            for _ in range(TURNS)
        ]
        for name in READERS:
            cpu = statistics.median(turn[name][0] for turn in turns)
            ratio = statistics.median(turn[name][0] / turn["bare"][0] for turn in turns)
            lost = sum(turn[name][1] for turn in turns)
            print(f"QoS {qos} {name:10}{cpu:16.1f}{ratio:10.2f}{lost:7}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 5:
        what, numbers = sys.argv[1], [int(number) for number in sys.argv[2:]]
        publish(*numbers) if what == "publish" else consume(what, *numbers)
    elif is_installed():
        main(float(sys.argv[1]) if len(sys.argv) == 2 else TURN_S)
    else:
        print("mosquitto is not installed")
