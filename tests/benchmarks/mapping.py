"""Payload mappings beside decoding by hand, in one run: nanoseconds of CPU from frame to sample.

`nox -s bench -- mapping` runs it and prints a table. The ratios are what matters: machines are
noisy, so the rows take turns, and the cheapest of their turns counts.

- decode: msgspec (the extra `fast`) turns the frame into dictionaries, and no more is done
- naive: `json.loads`, and the numbers are picked by hand; no checks
- mapping: `ImuMapping.compile()`, with every check

`python tests/benchmarks/mapping.py FOLDER` has a row for another `rosbase` too, the one in a
folder, such as the sources of the commit before. The two take turns: a plain preset must not cost
more than 1.05 times what it did.
"""

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

TURNS = 11
ROUNDS, LINES = 40, 200
Read: TypeAlias = Callable[[bytes], Any]


def ros_lines() -> Iterable[bytes]:
    from rosbase.imu.simulator import payload_at
    from rosbase.messages import Time

    return (payload_at(n / 1000, Time(1_700_000_000 + n, n)) for n in range(LINES))


def mpu6050_lines() -> Iterable[bytes]:
    for n in range(LINES):
        yield (
            f'{{"accel_x":{n / 1e3:.4f},"accel_y":0.0217,"accel_z":9.8{n},"gyro_x":0.01,'
            f'"gyro_y":-0.02,"gyro_z":{n / 100:.3f},"temperature":21.5}}'
        ).encode()


def naive_ros(line: bytes) -> Any:
    """What a hand-written reader does: no checks."""
    data = json.loads(line)
    q, w, a = data["orientation"], data["angular_velocity"], data["linear_acceleration"]
    return (
        (q["x"], q["y"], q["z"], q["w"]),
        (w["x"], w["y"], w["z"]),
        (a["x"], a["y"], a["z"]),
    )


def naive_mpu6050(line: bytes) -> Any:
    data = json.loads(line)
    return (
        (data["gyro_x"], data["gyro_y"], data["gyro_z"]),
        (data["accel_x"], data["accel_y"], data["accel_z"]),
    )


def mapped(preset: str) -> Read:
    from rosbase.imu.mapping import ImuMapping
    from rosbase.imu.presets import PRESETS

    (values,) = [plugin.values for plugin in PRESETS if plugin.name == preset]
    fields: dict[str, Any] = {
        key.replace(".", "_"): tuple(value) if isinstance(value, list) else value
        for key, value in values.items()
    }
    return ImuMapping(**fields).compile()


def decoder() -> Read:
    from msgspec.json import Decoder

    decode: Read = Decoder().decode
    return decode


def measure(read: Read, lines: list[bytes]) -> float:
    """Nanoseconds of CPU for each frame, in the cheapest round."""
    assert read(lines[0])
    best = float("inf")
    for _ in range(ROUNDS):
        start = time.thread_time_ns()
        for line in lines:
            read(line)
        best = min(best, (time.thread_time_ns() - start) / len(lines))
    return best


def child() -> None:
    """Measures each way once, and prints the numbers as JSON."""
    ros, mpu6050 = list(ros_lines()), list(mpu6050_lines())
    print(
        json.dumps(
            {
                "ros": {
                    "decode": measure(decoder(), ros),
                    "naive": measure(naive_ros, ros),
                    "mapping": measure(mapped("ros"), ros),
                },
                "mpu6050": {
                    "decode": measure(decoder(), mpu6050),
                    "naive": measure(naive_mpu6050, mpu6050),
                    "mapping": measure(mapped("mpu6050"), mpu6050),
                },
            }
        )
    )


def run(source: str) -> dict[str, dict[str, float]]:
    """One turn in a process of its own; with the rosbase in a folder, if one is named."""
    environment = {**os.environ, "PYTHONPATH": source} if source else os.environ
    done = subprocess.run(
        [sys.executable, __file__, "--child"],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    measured: dict[str, dict[str, float]] = json.loads(done.stdout)
    return measured


def main(before: str) -> None:
    """Prints the table."""
    now: list[dict[str, dict[str, float]]] = []
    then: list[dict[str, dict[str, float]]] = []
    for _ in range(TURNS):
        now.append(run(""))
        if before:
            then.append(run(before))
    print(f"{'':10}{'':10}{'ns CPU/frame':>14}{'of naive':>10}")
    for preset in now[0]:
        naive = min(turn[preset]["naive"] for turn in now)
        for way in now[0][preset]:
            best = min(turn[preset][way] for turn in now)
            print(f"{preset:10}{way:10}{best:14.0f}{best / naive:10.2f}")
        if before:
            best = min(turn[preset]["mapping"] for turn in then)
            print(f"{preset:10}{'before':10}{best:14.0f}{best / naive:10.2f}")
            pairs = zip(now, then, strict=True)
            ratios = [a[preset]["mapping"] / b[preset]["mapping"] for a, b in pairs]
            median = statistics.median(ratios)
            print(f"{preset:10}mapping / before, median of the turns: {median:.2f}")


if __name__ == "__main__":
    if sys.argv[1:] == ["--child"]:
        child()
    else:
        main(sys.argv[1] if len(sys.argv) > 1 else "")
