"""A manager whose entries are recorded."""

import os
import signal
import threading
from collections.abc import Iterable
from typing import Any

import pytest

from rosbase import BaseManager, BaseNode, SystemClock
from rosbase.entries.current import conduct_next
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace, TraceBlock
from rosbase.manager.main_loop import run_main_loop
from rosbase.manager.precise_loop import run_precise_loop
from rosbase.messages import Bool
from rosbase.runtime.executor import Executor
from rosbase.testing import ManualClock, virtual_backend


class Memory:
    """Keeps a recording."""

    def __init__(self) -> None:
        self.ends: list[EndFacts] = []
        self.facts: list[RunFacts] = []

    def begin(self, backend: Any, conductor: Any, trace: Trace, facts: RunFacts) -> None:
        self.trace = trace
        self.facts.append(facts)

    def close(self, end: EndFacts) -> None:
        self.ends.append(end)
        self.blocks: Iterable[TraceBlock] = [self.trace.take()]

    def entries(self) -> list[Entry]:
        return list(read_entries(self.blocks))


class Blinker(BaseNode):
    def __init__(self, manager: Any, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.heard: list[bool] = []
        self.out = self.create_publisher(Bool, "lamp")
        self.create_subscription(Bool, "lamp", lambda message: self.heard.append(message.data))
        self.create_timer(0.02, lambda: self.out.publish(Bool(True)))
        self.create_timer(0.05, lambda: self.out.publish(Bool(False)))


class Robot(BaseManager):
    ticks = 20

    def main_loop(self) -> None:
        super().main_loop()
        if self.timestamp == self.ticks:
            self.request_stop()


def recorded(clock: Any) -> tuple[Memory, Any]:
    memory = Memory()
    return memory, virtual_backend(Recorder(clock, memory).clock)


def check(entries: list[Entry], robot: Robot) -> None:
    """Check that the entries say what the manager did."""
    kinds = [entry.kind for entry in entries]
    assert kinds.count(Kind.TICK) == kinds.count(Kind.TICK_END) == robot.timestamp
    assert kinds[-1] is Kind.END
    heard = len(robot.nodes["blinker"].heard)
    assert kinds.count(Kind.TIMER) >= heard > 0
    assert kinds.count(Kind.CALL) >= heard
    assert not any(entry.notes.spoiled for entry in entries)


def test_a_manager_in_virtual_time_runs_as_without_a_recording() -> None:
    plain = Robot("robot", {"blinker": Blinker}, node_freq_hz=100, backend=virtual_backend())
    plain.start_main_loop_timer()
    memory, backend = recorded(ManualClock())
    robot = Robot("robot", {"blinker": Blinker}, node_freq_hz=100, backend=backend)
    robot.start_main_loop_timer()
    assert robot.nodes["blinker"].heard == plain.nodes["blinker"].heard
    assert robot.backend.clock.elapsed_ns == plain.backend.clock.elapsed_ns  # type: ignore[attr-defined]  # of a ManualClock
    check(memory.entries(), robot)


@pytest.mark.parametrize("timing", ["normal", "precise"])
def test_a_manager_in_real_time_is_recorded(timing: Any) -> None:
    memory, backend = recorded(SystemClock())
    robot = Robot("robot", {"blinker": Blinker}, node_freq_hz=200, backend=backend, timing=timing)
    robot.start_main_loop_timer()
    check(memory.entries(), robot)
    assert memory.ends[0].ended_by == ""


def test_ticks_have_the_times_of_the_statistics() -> None:
    memory, backend = recorded(ManualClock())
    robot = Robot("robot", {"blinker": Blinker}, node_freq_hz=100, backend=backend)
    notes = robot.loop_stats.notes
    robot.start_main_loop_timer()
    times = [e.t_ns for e in memory.entries() if e.kind in (Kind.TICK, Kind.TICK_END)]
    assert times == [note - memory.facts[0].start_monotonic_ns for note in notes]


def test_a_signal_is_a_stop() -> None:
    memory, backend = recorded(SystemClock())

    class Killed(Robot):
        def main_loop(self) -> None:
            super().main_loop()
            if self.timestamp == 5:
                os.kill(os.getpid(), signal.SIGTERM)

    robot = Killed("robot", {"blinker": Blinker}, node_freq_hz=200, backend=backend)
    robot.start_main_loop_timer()
    kinds = [entry.kind for entry in memory.entries()]
    assert kinds.count(Kind.STOP) == 1
    assert robot.timestamp < Robot.ticks


def test_an_error_ends_the_recording_with_its_text() -> None:
    memory, backend = recorded(ManualClock())

    class Broken(Robot):
        def main_loop(self) -> None:
            raise ValueError("no leg")

    with pytest.raises(ValueError, match="no leg"):
        Broken("robot", backend=backend).start_main_loop_timer()
    assert memory.ends[0].ended_by == "ValueError: no leg"
    assert memory.entries()[-1].kind is Kind.END


def test_a_thread_of_the_user_publishes_at_any_time() -> None:
    memory, backend = recorded(SystemClock())
    sent = threading.Event()

    class Talker(Blinker):
        def talk(self) -> None:
            for _ in range(50):
                self.out.publish(Bool(True))
            sent.set()

    class Talkative(Robot):
        def main_loop(self) -> None:
            super().main_loop()
            if self.timestamp == 2:
                self.thread = threading.Thread(target=self.nodes["blinker"].talk)
                self.thread.start()

        def release_resources(self) -> None:
            self.thread.join()

    robot = Talkative("robot", {"blinker": Talker}, node_freq_hz=200, backend=backend)
    robot.start_main_loop_timer()
    assert sent.is_set()
    published = [e for e in memory.entries() if e.kind is Kind.PUBLISH]
    assert len(published) == 50
    assert all(entry.payload for entry in published)


def test_the_next_program_is_recorded_and_no_other() -> None:
    memory = Memory()
    conduct_next(lambda clock: Recorder(clock, memory))
    first = BaseNode(node_name="first")
    second = BaseNode(node_name="second")
    assert first._connection.conductor is not None  # type: ignore[attr-defined]  # a backend
    assert second._connection.conductor is None  # type: ignore[attr-defined]  # a backend
    first.destroy_node()
    second.destroy_node()
    assert [end.ended_by for end in memory.ends] == [""]


def test_without_a_recording_the_classes_are_the_plain_ones() -> None:
    manager = BaseManager("robot", backend="local")
    precise = BaseManager("precise", backend="local", timing="precise")
    try:
        assert type(manager.backend.executor) is Executor
        assert type(manager.backend.clock) is SystemClock
        assert manager.backend.conductor is None
        assert manager._run_loop is run_main_loop
        assert precise._run_loop is run_precise_loop
    finally:
        manager.destroy_node()
        precise.destroy_node()
