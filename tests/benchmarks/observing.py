"""What it costs a program to be looked at: an Imu at 1 kHz, counted and echoed by a client.

`nox -s bench` runs it and prints a table. Observer and observed are processes of their own. The
rows take turns; the medians of the turns count.

- alone: nobody looks
- count: a client of the control socket asks for `topic.count`, as `rosbase topic hz` does
- echo: a client asks for `topic.echo`, and decodes each message
- rclpy: a subscriber of rclpy, whose callback counts (on `ros2` only)
- left: a client has counted and echoed, and has gone

"counted" is what the observer has counted of the published messages; it is exact but for rclpy,
whose subscriber may find the publisher late.
"""

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from attrs import frozen

from benchmarks.rig.turns import take_turns
from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.messages import Header, Imu, Vector3
from support.ros_domain import own_domain

RATE_HZ = 1000
WARM_UP = 1000
MEASURED = 4000
# The last window of a count comes within this.
AFTERWARDS = 1500
TURNS = 5
ROWS = {
    "local": ("alone", "count", "echo", "left"),
    "ros2": ("alone", "count", "echo", "rclpy", "left"),
}


class Talker(BaseNode):
    """Publishes."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.imu = self.create_publisher(Imu, "imu", 10)


class Handlers(BaseHandlers):
    """Publishes in each tick; prints its CPU and what it has published."""

    def handle(self) -> None:
        tick = self.timestamp
        if tick < WARM_UP + MEASURED:
            header = Header(self.manager.backend.clock.now(), "imu_link")
            self.node(Talker).imu.publish(Imu(header, angular_velocity=Vector3(1.0, 2.0, 3.0)))
        if tick == WARM_UP:
            self.before_ns = time.process_time_ns()
        if tick == WARM_UP + MEASURED:
            print(time.process_time_ns() - self.before_ns, tick, flush=True)
        if tick == WARM_UP + MEASURED + AFTERWARDS:
            self.manager.request_stop()


def observed(backend: str, go: str) -> None:
    """The program: it begins once a file is there."""
    manager = BaseManager(
        "loop", {"talker": Talker}, {}, Handlers, node_freq_hz=RATE_HZ, backend=backend
    )
    manager.add_handshake_rule("the observer", Path(go).exists)
    manager.start_main_loop_timer()


def observe(what: str, path: str, go: str) -> None:
    """A client of the control socket, until the program ends."""
    from rosbase.wire.plain import decoder
    from support.control import Asker

    client, counted = Asker(path), 0
    if what == "left":
        for ask in ("topic.count", "topic.echo"):
            client.ask(ask, topic="/imu")
        client.close()
        Path(go).touch()
        return
    told = client.ask(f"topic.{what}", topic="/imu", limit=10_000)
    read = decoder(told["type"], told["schema"]) if what == "echo" else None
    Path(go).touch()
    before_ns = time.process_time_ns()
    while True:
        frame, data = client.read()
        if "end" in frame:
            break
        if read is not None:
            read(data)
            counted += 1
        else:
            counted = frame["event"]["n"]
    print(time.process_time_ns() - before_ns, counted)


def subscribe(go: str) -> None:
    """A subscriber of rclpy, until it is told to end."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from sensor_msgs.msg import Imu as RosImu

    counted, before_ns = [0], 0

    def count(_message: Any) -> None:
        counted[0] += 1

    rclpy.init()
    node: Any = rclpy.create_node("observer")
    node.create_subscription(RosImu, "imu", count, 1000)
    while not node.count_publishers("imu"):
        time.sleep(0.05)
    before_ns = time.process_time_ns()
    Path(go).touch()
    try:
        rclpy.spin(node)
    except (ExternalShutdownException, KeyboardInterrupt):
        pass
    print(time.process_time_ns() - before_ns, counted[0])


@frozen
class Turn:
    """What one turn of one row measured."""

    observed_us: float
    """CPU of the observed process for each message."""
    observer_us: float
    counted: int
    published: int


def measure(backend: str, what: str) -> Turn:
    """One turn."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        go = str(Path(folder, "go"))
        start = partial(subprocess.Popen, stdout=subprocess.PIPE, text=True)
        program = start([sys.executable, __file__, "observed", backend, go])
        path = Path(folder, "rosbase", f"{program.pid}.sock")
        observer = None
        if what == "alone":
            Path(go).touch()
        elif what == "rclpy":
            observer = start([sys.executable, __file__, "subscribe", go])
        else:
            while not (path.exists() and _listens(path)):
                time.sleep(0.05)
            observer = start([sys.executable, __file__, "observe", what, str(path), go])
        cpu_ns, published = map(int, _said(program))
        cost_ns = counted = 0
        if observer is not None:
            if what == "rclpy":
                observer.send_signal(signal.SIGINT)
            if what != "left":
                cost_ns, counted = map(int, _said(observer))
            observer.wait()
    return Turn(cpu_ns / 1000 / MEASURED, cost_ns / 1000 / max(1, counted), counted, published)


def _listens(path: Path) -> bool:
    from rosbase.control.socket_file import refuses

    return not refuses(str(path))


def _said(process: "subprocess.Popen[str]") -> list[str]:
    out, _ = process.communicate()
    return out.split()


def print_table(title: str, rows: dict[str, list[Turn]]) -> None:
    """Prints medians, and the differences to the row `alone`."""
    print(
        f"\n{title}, {RATE_HZ} Hz\n{'':10}{'us/message':>12}{'more':>8}{'of a core':>11}"
        f"{'observer us':>13}{'counted':>16}"
    )
    for name, turns in rows.items():
        own = statistics.median(turn.observed_us for turn in turns)
        more = statistics.median(
            turn.observed_us - alone.observed_us
            for turn, alone in zip(turns, rows["alone"], strict=True)
        )
        observer = statistics.median(turn.observer_us for turn in turns)
        exact = sum(turn.counted == turn.published for turn in turns)
        share = more * RATE_HZ / 1e6
        print(
            f"{name:10}{own:12.1f}{more:8.1f}{share:11.2%}{observer:13.1f}"
            f"{f'{exact} of {len(turns)} exact':>16}"
        )


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(own_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    wanted: Sequence[str] = sys.argv[1:] or [*ROWS]
    for backend in wanted:
        rows = take_turns(partial(measure, backend), ROWS[backend], TURNS)
        print_table(backend, rows)


if __name__ == "__main__":
    roles: dict[str, Any] = {"observed": observed, "observe": observe, "subscribe": subscribe}
    if sys.argv[1:] and sys.argv[1] in roles:
        roles[sys.argv[1]](*sys.argv[2:])
    else:
        main()
