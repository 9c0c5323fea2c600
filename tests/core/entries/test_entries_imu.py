"""The reader of an IMU, recorded with a device and its thread, and replayed without."""

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

import pytest

from rosbase import BaseHandlers, BaseManager, SystemClock
from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.transport import Transport, TransportContext
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.errors import TransportError
from rosbase.imu.reader import ImuReader
from rosbase.local import Bus, LocalBackend
from rosbase.messages import DiagnosticArray, Imu
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin, installed_plugins
from support.fifo import PARAMETERS, FifoPeer, make_transport
from support.samples import FAULTS, frame

S = 1_000_000_000
FRAMES = 150
BAD = [line for line, _ in FAULTS.values() if len(line) < 1000]


class FifoRegistry:
    """The installed plugins, with a pipe as the only transport."""

    def __init__(self) -> None:
        self._installed = installed_plugins()
        self._plugin = TransportPlugin("fifo", "a pipe", self._make, PARAMETERS)
        self.made: list[Transport] = []

    @property
    def transports(self) -> Mapping[str, TransportPlugin]:
        return {"fifo": self._plugin}

    def transport(self, name: str) -> TransportPlugin:
        return self._plugin

    def is_ours(self, kind: str, name: str) -> bool:
        return False

    def preset(self, name: str) -> Any:
        return self._installed.preset(name)

    def _make(self, values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
        self.made.append(make_transport(values, context))
        return self.made[-1]


class Watch(BaseHandlers):
    """Stops when enough has come, and looks at the reader meanwhile."""

    manager: Any

    def handle(self) -> None:
        reader: ImuReader = self.manager.node(ImuReader)
        if self.timestamp % 10 == 0:
            self.manager.see("health", reader.health.level.name, reader.counts.published)
            self.manager.see("transport", reader.transport_health)
        if len(self.manager.heard) >= FRAMES:
            self.manager.request_stop()


class Robot(BaseManager):
    """A reader on a pipe, and an agent that hears it."""

    def __init__(self, clock: Any, path: str, registry: FifoRegistry) -> None:
        self.seen: list[Any] = []
        self.heard: list[Imu] = []
        overrides: dict[str, ParameterValue] = {
            "reader.comm_t": "fifo",
            "reader.fifo_path": path,
            "reader.wait": True,
            "reader.autostart": "activate",
        }
        options = BackendOptions("robot", overrides, clock)
        super().__init__(
            "robot",
            {"reader": ImuReader},
            handlers_class=Watch,
            node_freq_hz=200,
            backend=LocalBackend(options, Bus()),
            registry=cast("Any", registry),
        )
        self.backend.create_subscription(Imu, "imu/data", self._hear, 1000)
        self.backend.create_subscription(DiagnosticArray, "/diagnostics", self._diagnose, 10)

    def see(self, *values: Any) -> None:
        self.seen.append(values)

    def _hear(self, message: Imu) -> None:
        self.heard.append(message)
        self.see("imu", message)

    def _diagnose(self, message: DiagnosticArray) -> None:
        self.see("diagnostics", message)


@contextmanager
def streaming(peer: FifoPeer) -> Iterator[None]:
    """A device that sends good and bad frames, and is unplugged once."""
    is_over = threading.Event()

    def send() -> None:
        # The pipe is closed at the end, when nobody reads.
        with suppress(TransportError):
            send_all()

    def send_all() -> None:
        number = 0
        while not is_over.wait(0.002):
            number += 1
            peer.send(frame(angular_velocity={"x": number / 7, "y": 0.0, "z": -1 / number}))
            if number % 5 == 0:
                peer.send(BAD[number // 5 % len(BAD)])
            if number == FRAMES // 2:
                peer.unplug()
                is_over.wait(0.05)
                peer.replug()

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        peer.close()
        thread.join()


def record(path: Path) -> tuple[Robot, list[Entry], RunFacts]:
    peer = FifoPeer(path)
    recorder = Recorder(SystemClock())
    robot = Robot(recorder.clock, str(peer.path), FifoRegistry())
    with streaming(peer):
        robot.start_main_loop_timer()
    assert recorder.spoiled == []
    facts = RunFacts(recorder.clock.start_date_ns, recorder.clock.start_ns)
    return robot, list(read_entries([recorder.trace.take()])), facts


def test_what_a_reader_published_comes_again_to_the_bit(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    recorded, script, facts = record(tmp_path)
    lines = caplog.record_tuples.copy()
    caplog.clear()
    assert len([entry for entry in script if entry.kind == Kind.FRAME]) > FRAMES
    assert {values[0] for values in recorded.seen} == {"imu", "health", "transport"}

    registry = FifoRegistry()
    player = Player(script, facts)
    replayed = Robot(player.clock, str(tmp_path / "not there"), registry)
    replayed.start_main_loop_timer()
    assert str(player.difference or "") == ""
    assert registry.made == []
    assert replayed.seen == recorded.seen
    assert any("was lost" in text for _, _, text in lines)
    assert caplog.record_tuples == lines
