"""How long `rosbase topic list` takes from its start to its end, beside Python and rclpy.

`nox -s bench -- cold_commands` runs it and prints a table. A program with a topic runs. The rows
take turns: `python -c pass`; the command; and, where rclpy is installed, a client of rclpy that
lists the topics once it has found the program's. The medians count.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from support.ros_domain import own_domain

TURNS = 21
MOST_RATIO = 2.5
"""Most of the time of `python -c pass` that the command may take."""
MOST_OF_RCLPY = 0.25

PROGRAM = """
import os
from rosbase import BaseNode
from rosbase.messages import Imu
node = BaseNode(node_name="robot", backend=os.environ["BENCH_BACKEND"])
publisher = node.create_publisher(Imu, "imu/data")
node.create_timer(0.01, lambda: publisher.publish(Imu()))
node.create_timer(0.2, lambda: print("ready", flush=True))
node.start_spin_standalone()
"""
CLIENT = """
import time, rclpy
rclpy.init()
node = rclpy.create_node("client")
while "/imu/data" not in (names := [name for name, _ in node.get_topic_names_and_types()]):
    time.sleep(0.01)
print(*names, sep="\\n")
"""


def has_rclpy() -> bool:
    try:
        import rclpy  # noqa: F401 - its import is measured
    except ImportError:
        return False
    return True


def timed(command: list[str]) -> float:
    """Seconds from the start of a process to its end."""
    start_s = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    took_s = time.perf_counter() - start_s
    assert "pass" in command or "/imu/data" in done.stdout, done
    return took_s


def medians(with_rclpy: bool) -> dict[str, float]:
    """Seconds by row, with the program running."""
    rows = {
        "python -c pass": [sys.executable, "-c", "pass"],
        "rosbase topic list": [str(Path(sys.executable).with_name("rosbase")), "topic", "list"],
    }
    if with_rclpy:
        rows["rclpy client"] = [sys.executable, "-c", CLIENT]
    times: dict[str, list[float]] = {name: [] for name in rows}
    # The first run of each compiles what it imports.
    for turn in range(TURNS + 1):
        for name, command in rows.items():
            took_s = timed(command)
            if turn:
                times[name].append(took_s)
    return {name: statistics.median(found) for name, found in times.items()}


def measure() -> dict[str, float]:
    """Medians in seconds by row."""
    with_rclpy = has_rclpy()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["BENCH_BACKEND"] = "ros2" if with_rclpy else "local"
    os.environ["ROS_DOMAIN_ID"] = str(own_domain())
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with tempfile.TemporaryDirectory(prefix="rosbase-") as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        command = [sys.executable, "-c", PROGRAM]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
            try:
                assert program.stdout is not None
                assert program.stdout.readline() == "ready\n"
                return medians(with_rclpy)
            finally:
                program.kill()


def main() -> None:
    found = measure()
    base_s = found["python -c pass"]
    print(f"{'':20} {'median':>10} {'ratio':>7}")
    for name, median_s in found.items():
        print(f"{name:20} {median_s * 1e3:7.1f} ms {median_s / base_s:7.2f}")
    own_s = found["rosbase topic list"]
    assert own_s <= MOST_RATIO * base_s, f"more than {MOST_RATIO} times `python -c pass`"
    if "rclpy client" in found:
        assert own_s <= MOST_OF_RCLPY * found["rclpy client"]


if __name__ == "__main__":
    main()
