"""What a view shows, without programs: reports that are made, a source that gives them, a clock."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from rosbase.clock import SystemClock
from rosbase.control.shapes import Process, Topic
from rosbase.messages import Imu
from rosbase.wire import schema
from rosbase.wire.plain import encoder
from rosbase_view.imu_picture import IMU
from rosbase_view.reports import (
    Counted,
    Heard,
    Logged,
    NodeReport,
    NodeRow,
    ParameterRow,
    Report,
    Survey,
    TopicKey,
)
from rosbase_view.source import Change, Gaze, Playback

__all__ = [
    "ARM",
    "IMU_SCHEMA",
    "IMU_TOPIC",
    "PID",
    "ROBOT",
    "MadeClock",
    "MadePlayback",
    "MadeSource",
    "imu",
    "imu_heard",
    "made_process",
    "made_program",
    "made_topic",
    "reports",
    "survey",
]

PID = 4711
SECOND = 1_000_000_000
IMU_TOPIC: TopicKey = ("/imu/data", PID)
ARM = ("/arm", PID)
ROBOT = ("robot", PID)
IMU_SCHEMA = schema(Imu)


class MadeClock(SystemClock):
    """A clock that stands still until it is set."""

    def __init__(self) -> None:
        self.time_ns = 1_000 * SECOND

    def monotonic_ns(self) -> int:
        return self.time_ns

    def pass_s(self, seconds: float) -> None:
        """Moves it on."""
        self.time_ns += int(seconds * SECOND)


class MadePlayback:
    """Controls of a recording that keep what they are asked."""

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []

    def play(self) -> None:
        self.calls.append(("play",))

    def pause(self) -> None:
        self.calls.append(("pause",))

    def seek(self, time_ns: int) -> None:
        self.calls.append(("seek", time_ns))

    def set_rate(self, rate: float) -> None:
        self.calls.append(("rate", rate))


class MadeSource:
    """A source that reports what a test gives it, and keeps what it is asked."""

    def __init__(self, *, can_change: bool = True) -> None:
        self.can_change = can_change
        self.playback: Playback | None = None
        self.waiting: list[Report] = []
        self.gazes: list[Gaze] = []
        self.changes: list[Change] = []
        self.calls: list[str] = []

    def start(self, on_news: Callable[[], object] | None = None) -> None:
        self.calls.append("start")

    def take(self) -> Sequence[Report]:
        taken, self.waiting = self.waiting, []
        return taken

    def look_at(self, gaze: Gaze) -> None:
        self.gazes.append(gaze)

    def schema_of(self, topic: TopicKey) -> tuple[str, str]:
        return IMU, IMU_SCHEMA

    def change(self, change: Change) -> None:
        self.changes.append(change)

    def close(self) -> None:
        self.calls.append("close")


def made_program(name: str = "/quadruped", **facts: Any) -> Any:
    """A program as it tells of itself."""
    return {
        "name": name,
        "kind": "manager",
        "phase": "running",
        "backend": "local",
        "network": "",
        "state": "walk",
        "waiting_for": [],
        "rate_hz": 200.0,
        "ticks": 5_000,
        "overruns": 1,
        "tick_ns": None,
        "up_ns": 83 * SECOND,
        "nodes": [name],
        "children": [],
        **facts,
    }


def made_process(pid: int = PID, *programs: Any, **facts: Any) -> Process:
    """A process as it tells of itself."""
    found: Any = {
        "pid": pid,
        "command": ["python", "quadruped.py"],
        "name": programs[0]["name"] if programs else "/quadruped",
        "python": "3.11.7",
        "rosbase": "0.1.0",
        "started_ns": 0,
        "cpu_ns": 0,
        "memory_bytes": 29_100_000,
        "threads": 3,
        "programs": list(programs or [made_program()]),
        "clients": 1,
        "dropped": 0,
        **facts,
    }
    made: Process = found
    return made


def made_topic(
    name: str, kind: str = IMU, publishers: Iterable[int] = (PID,), subscribers: Iterable[int] = ()
) -> Topic:
    """A topic with its ends."""

    def end(pid: int) -> Any:
        return {"pid": pid, "node": "/quadruped", "qos": None, "dropped": 0}

    return {
        "name": name,
        "types": [kind],
        "publishers": [end(pid) for pid in publishers],
        "subscriptions": [end(pid) for pid in subscribers],
    }


def survey(topics: int = 5) -> Survey:
    """One program with an IMU and other topics, two nodes, and a main loop."""
    found = {IMU_TOPIC: made_topic("/imu/data")}
    for number in range(topics - 1):
        name = f"/joint_{number:02d}/state"
        found[name, PID] = made_topic(name, "std_msgs/msg/Float64")
    times = {"count": 5_000, "min_ns": 4_900_000, "p50": 5_000_000, "p90": 5_050_000,
             "p99": 5_120_000, "p999": 5_900_000, "max_ns": 9_000_000,
             "histogram": [[4_950_000, 20], [5_000_000, 3_000], [5_120_000, 1_900],
                           [9_000_000, 80]]}  # fmt: skip
    loop: Any = {
        "pid": PID, "program": "/quadruped", "period": times, "busy": times, "ticks": 5_000,
        "overruns": 1, "tick_ns": None, "rate_hz": 200.0,
    }  # fmt: skip
    return Survey(
        [made_process()],
        found,
        [NodeRow(ROBOT, "/quadruped", None), NodeRow(ARM, "/quadruped", "inactive")],
        [loop],
    )


def imu(yaw_degrees: float = 30.0) -> dict[str, Any]:
    """An Imu as plain data, turned about the vertical axis."""
    half = math.radians(yaw_degrees) / 2.0
    return {
        "header": {"stamp": {"sec": 12, "nanosec": 345_000_000}, "frame_id": "imu_link"},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
        "orientation_covariance": (0.0,) * 9,
        "angular_velocity": {"x": 0.01, "y": -0.5, "z": 1.25},
        "angular_velocity_covariance": (0.0,) * 9,
        "linear_acceleration": {"x": 0.3, "y": -0.1, "z": 9.80665},
        "linear_acceleration_covariance": (0.0,) * 9,
    }


def imu_heard(yaw_degrees: float = 30.0, **fields: Any) -> Heard:
    """A report on such a message, with these fields in place of its own."""
    data = encoder(IMU, IMU_SCHEMA)({**imu(yaw_degrees), **fields})
    return Heard(IMU_TOPIC, IMU, IMU_SCHEMA, 0, data)


def counted(key: TopicKey, number: int) -> Iterator[Counted]:
    """Eight seconds of a topic: the first one is even, the others come and go."""
    for step in range(16):
        part = 1.0 if number == 0 else 0.55 + 0.45 * math.sin(0.5 * step + number)
        yield Counted(key, round((100 - number) * part), 0.5, (15 - step) * 0.5)


def reports(topics: int = 5) -> list[Report]:
    """Everything that a source may tell, at one moment."""
    found = survey(topics)
    record: Any = {
        "pid": PID, "stamp_ns": 0, "level": 30, "name": "quadruped", "text": "the battery is low",
    }  # fmt: skip
    speed = ParameterRow("speed", "double", 1.5, "Speed in m/s.", "from 0 to 2", False)
    frame = ParameterRow("frame_id", "string", "imu_link", "Frame of the IMU.", "", True)
    return [
        found,
        *(one for number, key in enumerate(found.topics) for one in counted(key, number)),
        Logged([record]),
        imu_heard(),
        NodeReport(ARM, [speed, frame], ["activate", "cleanup", "shutdown"]),
    ]
