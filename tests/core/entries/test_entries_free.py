"""A manager whose program has changed since it was recorded: the rest follows in virtual time."""

import signal
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.contracts.transport import TransportContext
from rosbase.device.conducted import conducted_transport
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.inputs import Input
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.logger import RosbaseLogger
from rosbase.messages import Vector3
from rosbase.testing import ManualClock, ScriptedTransport, virtual_backend
from support.conducted import on_thread

MS = 1_000_000
FACTS = RunFacts(ManualClock().now_ns(), 0)
Change = Callable[["Robot"], object]


class Arm(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.out = self.create_publisher(Vector3, "angle", 10)
        self.create_subscription(Vector3, "angle", lambda m: manager.note("angle", m.x), 10)
        self.create_timer(0.025, lambda: self.out.publish(Vector3(x=float(manager.timestamp))))


class Ticks(BaseHandlers):
    manager: Any

    def handle(self) -> None:
        self.manager.tick()


class Robot(BaseManager):
    """Ticks at 100 Hz, has a frame in the ticks 3 and 7, and stops in the tick 9."""

    def __init__(self, backend: Any, change: Change | None = None, change_at: int = 5) -> None:
        self.log: list[tuple[int, str, Any]] = []
        self.change, self.change_at = change, change_at
        self.made: list[ScriptedTransport] = []
        super().__init__(
            "robot", {"arm": Arm}, handlers_class=Ticks, node_freq_hz=100, backend=backend
        )
        context = TransportContext(backend.clock, RosbaseLogger("robot"))
        self.transport = conducted_transport(backend.conductor, "device", self._make, context)
        self.transport.start(lambda frame, stamp_ns: self.note("frame", frame))

    def note(self, what: str, value: Any = None) -> None:
        machine = self.backend.clock.machine  # type: ignore[attr-defined]  # of a conducted one
        self.log.append((machine.monotonic_ns() // MS, what, value))

    def tick(self) -> None:
        self.note("tick", self.timestamp)
        if self.made and self.timestamp in (3, 7):
            on_thread(lambda: self.made[0].deliver(b"%d" % self.timestamp))
        if self.change is not None and self.timestamp == self.change_at:
            self.change(self)
        if self.made and self.timestamp == 9:
            self.request_stop()

    def release_resources(self) -> None:
        self.transport.close()

    def of(self, what: str) -> list[tuple[int, Any]]:
        return [(time_ms, value) for time_ms, one, value in self.log if one == what]

    def _make(self, context: TransportContext) -> ScriptedTransport:
        self.made.append(ScriptedTransport({}, context))
        return self.made[0]


def record() -> tuple[Robot, list[Entry]]:
    recorder = Recorder(ManualClock())
    robot = Robot(virtual_backend(recorder.clock))
    robot.start_main_loop_timer()
    return robot, list(read_entries([recorder.trace.take()]))


def replay(script: list[Entry], *args: Any, **options: Any) -> tuple[Robot, Player]:
    player = Player(script, FACTS, **options)
    robot = Robot(virtual_backend(player.clock), *args)
    return robot, player


def create_timer(robot: Robot) -> None:
    robot.node(Arm).create_timer(0.002, partial(robot.note, "new"))


def test_without_a_change_all_is_the_same() -> None:
    # The stop of the recorded program is within a tick, so the replayed one stops itself too.
    def stop(robot: Robot) -> None:
        robot.request_stop()

    recorded, script = record()
    robot, player = replay(script, stop, 9)
    robot.start_main_loop_timer()
    assert player.difference is None
    assert robot.log == recorded.log


def test_ticks_timers_and_frames_go_on_at_their_times() -> None:
    recorded, script = record()
    robot, player = replay(script, create_timer)
    robot.start_main_loop_timer()
    assert player.difference is not None
    assert player.difference.tick == 6
    assert "creates a timer: Robot.note" in player.difference.what
    assert robot.of("tick") == recorded.of("tick")
    assert robot.of("frame") == recorded.of("frame") == [(30, b"3"), (70, b"7")]
    assert robot.of("angle") == recorded.of("angle")
    assert [time_ms for time_ms, _ in robot.of("new")] == list(range(52, 91, 2))


def test_a_program_that_would_go_on_is_stopped_where_the_recording_ends() -> None:
    recorded, script = record()
    robot, player = replay(script)
    robot.start_main_loop_timer()
    assert player.difference is not None
    assert robot.of("tick") == recorded.of("tick")
    assert robot.backend.clock.monotonic_ns() == 90 * MS


def test_statistics_go_on() -> None:
    def slow(robot: Robot) -> None:
        create_timer(robot)
        robot.backend.clock.sleep(0.025)

    _, script = record()
    robot, _ = replay(script, slow)
    robot.start_main_loop_timer()
    # As on a machine: the late tick runs at once, and the one whose period has passed is skipped.
    assert [time_ms for time_ms, _ in robot.of("tick")] == [*range(0, 60, 10), 75, 80, 90]
    assert robot.loop_stats.ticks == 9
    assert robot.loop_stats.overruns == 1


def test_a_frame_that_comes_during_a_slow_tick_comes_after_it() -> None:
    def slow(robot: Robot) -> None:
        create_timer(robot)
        robot.backend.clock.sleep(0.025)

    _, script = record()
    robot, _ = replay(script, slow)
    robot.start_main_loop_timer()
    assert robot.of("frame") == [(30, b"3"), (75, b"7")]


def test_an_exception_that_was_not_recorded_is_a_difference() -> None:
    def fail(robot: Robot) -> None:
        raise ValueError("no such leg")

    _, script = record()
    robot, player = replay(script, fail)
    with pytest.raises(ValueError, match="no such leg"):
        robot.start_main_loop_timer()
    assert player.difference is not None
    assert player.difference.what == (
        "the tick raised ValueError: no such leg; in the recording: the end of a tick (00:00.050)"
    )


def test_an_exception_that_was_recorded_is_none() -> None:
    def fail(robot: Robot) -> None:
        raise ValueError("no such leg")

    recorder = Recorder(ManualClock())
    recorded = Robot(virtual_backend(recorder.clock), fail)
    with pytest.raises(ValueError, match="no such leg"):
        recorded.start_main_loop_timer()
    script = list(read_entries([recorder.trace.take()]))
    robot, player = replay(script, fail)
    with pytest.raises(ValueError, match="no such leg"):
        robot.start_main_loop_timer()
    assert player.difference is None
    assert robot.log == recorded.log


def test_a_call_that_is_queued_in_addition_is_a_difference_before_the_next_tick() -> None:
    _, script = record()
    robot, player = replay(script, lambda robot: robot.backend.call_soon(list))
    robot.start_main_loop_timer()
    assert player.difference is not None
    assert player.difference.what.startswith("1 instead of 0 calls wait before a tick")


def test_a_signal_ends_the_replay() -> None:
    _, script = record()
    robot, player = replay(script, lambda _: signal.raise_signal(signal.SIGTERM))
    robot.start_main_loop_timer()
    assert player.was_interrupted
    assert player.difference is None
    assert [value for _, value in robot.of("tick")] == [*range(6)]


def test_chosen_inputs_drive_a_manager_without_a_script() -> None:
    robots: list[Robot] = []

    def speak(text: str) -> None:
        robots[0].note(text)

    inputs = [Input(20 * MS, partial(speak, "first")), Input(45 * MS, partial(speak, "last"))]
    robot, player = replay([], None, 5, inputs=inputs)
    robots.append(robot)
    robot.start_main_loop_timer()
    assert player.difference is None
    assert robot.of("first") == [(20, None)]
    assert robot.of("last") == [(45, None)]
    assert [time_ms for time_ms, _ in robot.of("tick")] == [0, 10, 20, 30, 40]
    # At one instant, a tick is first.
    assert robot.log.index((20, "tick", 2)) < robot.log.index((20, "first", None))


def test_a_replay_that_was_cut_off_stops_in_the_middle() -> None:
    recorded, script = record()
    ticks = [n for n, entry in enumerate(script) if entry.kind == Kind.TICK]
    robot, player = replay(script[: ticks[4]])
    robot.start_main_loop_timer()
    assert player.difference is None
    assert robot.log == recorded.log[: len(robot.log)]
    assert [value for _, value in robot.of("tick")] == [0, 1, 2, 3]
