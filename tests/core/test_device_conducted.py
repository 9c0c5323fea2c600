"""A transport of a program that is recorded, and the same one when it is replayed."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from rosbase.clock import SystemClock
from rosbase.contracts.transport import OnFrame, Transport, TransportContext, TransportState
from rosbase.device.conducted import conducted_transport
from rosbase.device.recorded_transport import RecordedTransport
from rosbase.device.replayed_transport import ReplayedTransport
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.errors import ConfigurationError, DeviceNotFoundError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor
from rosbase.testing import ManualClock, ScriptedTransport
from support.conducted import on_thread

S = 1_000_000_000
Log = list[Any]


class Program:
    """A program with a transport."""

    def __init__(self, conductor: Conductor) -> None:
        self.conductor = conductor
        self.executor: Executor = conductor.make_executor()
        conductor.register(Kind.STOP, lambda _: None)
        self.executor.begin(lambda: False)
        self.log: Log = []
        self.made: list[ScriptedTransport] = []

    def transport(self, create: Callable[[TransportContext], Transport] | None = None) -> Transport:
        context = TransportContext(self.conductor.clock, RosbaseLogger("conducted"))
        return conducted_transport(self.conductor, "scripted", create or self.create, context)

    def create(self, context: TransportContext) -> ScriptedTransport:
        self.made.append(ScriptedTransport({}, context))
        return self.made[-1]

    def take(self, frame: bytes, stamp_ns: int) -> bool:
        self.log.append((frame, stamp_ns, self.conductor.clock.monotonic_ns()))
        return frame != b"bad"

    def spin(self, seconds: float) -> None:
        deadline_ns = self.conductor.clock.monotonic_ns() + int(seconds * S)
        self.executor.spin_until(deadline_ns, lambda: False)

    def send(self, *frames: bytes) -> None:
        """Let the device send frames now, if there is one."""
        if self.made:
            thread = threading.Thread(target=partial(self._send, frames))
            thread.start()
            thread.join()

    def _send(self, frames: tuple[bytes, ...]) -> None:
        for frame in frames:
            self.log.append(("answer", self.made[-1].deliver(frame, 7)))


def record(run: Callable[[Program], object]) -> tuple[Program, list[Entry]]:
    recorder = Recorder(ManualClock())
    program = Program(recorder)
    run(program)
    recorder.end(None)
    return program, list(read_entries([recorder.trace.take()]))


def replay(run: Callable[[Program], object], script: list[Entry]) -> tuple[Program, Player]:
    player = Player(script, RunFacts(ManualClock().now_ns(), 0))
    program = Program(player)
    run(program)
    player.end(None)
    return program, player


def without_answers(log: Log) -> Log:
    return [entry for entry in log if not (isinstance(entry, tuple) and entry[0] == "answer")]


def assert_replays(run: Callable[[Program], object]) -> Program:
    recorded, script = record(run)
    replayed, player = replay(run, script)
    assert player.difference is None
    assert replayed.made == []
    assert replayed.log == without_answers(recorded.log)
    return recorded


def test_frames_come_again_at_their_times() -> None:
    def run(program: Program) -> None:
        transport = program.transport()
        transport.start(program.take)
        program.send(b"one", b"two")
        program.spin(0.5)
        program.send(b"three")
        program.spin(0.5)
        transport.close()

    recorded = assert_replays(run)
    assert without_answers(recorded.log) == [
        (b"one", 7, 0),
        (b"two", 7, 0),
        (b"three", 7, S // 2),
    ]


def test_errors_and_health_come_again() -> None:
    def run(program: Program) -> None:
        transport = program.transport()
        program.log.append(transport.health)
        for scripted in program.made:
            scripted.failure = DeviceNotFoundError("/dev/imu is not there")
        with pytest.raises(DeviceNotFoundError) as raised:
            transport.open()
        program.log.append(str(raised.value))
        for scripted in program.made:
            scripted.failure = None
            scripted.frame_errors = {"checksum": 3}
        transport.open()
        program.log.append((transport.is_open, transport.health))
        transport.close()
        program.log.append((transport.is_open, transport.health))

    recorded = assert_replays(run)
    assert recorded.log[1] == "/dev/imu is not there"
    assert recorded.log[2][1].frame_errors == {"checksum": 3}


def test_a_transport_that_cannot_be_made_cannot_be_made_in_a_replay() -> None:
    def refuse(context: TransportContext) -> Transport:
        raise ConfigurationError("serial.port is empty")

    def run(program: Program) -> None:
        with pytest.raises(ConfigurationError) as raised:
            program.transport(refuse)
        program.log.append(str(raised.value))

    assert assert_replays(run).log == ["serial.port is empty"]


def test_frames_that_come_while_the_device_is_opened_come_at_that_place() -> None:
    def run(program: Program) -> None:
        class SendsAtOnce(ScriptedTransport):
            def start(self, on_frame: OnFrame) -> None:
                super().start(on_frame)
                program.made.append(self)
                program.send(b"first")

        transport = program.transport(lambda context: SendsAtOnce({}, context))
        program.log.append("before")
        transport.start(program.take)
        program.log.append("after")

    recorded = assert_replays(run)
    assert [entry if isinstance(entry, str) else entry[0] for entry in recorded.log] == [
        *("before", b"first", "answer", "after")
    ]


def test_no_frame_comes_after_stop() -> None:
    def run(program: Program) -> None:
        transport = program.transport()
        transport.start(program.take)
        program.send(b"before")
        transport.stop()
        program.log.append("stopped")
        program.spin(0.5)

    recorded = assert_replays(run)
    assert [entry if isinstance(entry, str) else entry[0] for entry in recorded.log] == [
        *("answer", b"before", "stopped")
    ]


def test_stopping_within_a_frame_ends_it_in_a_replay_too() -> None:
    def run(program: Program) -> None:
        transport = program.transport()

        def take_one(frame: bytes, stamp_ns: int) -> None:
            program.log.append(frame)
            transport.stop()
            transport.start(program.take)

        transport.start(take_one)
        program.send(b"one", b"two")
        program.spin(0.5)

    recorded, script = record(run)
    replayed, player = replay(run, script)
    assert player.difference is None
    assert replayed.log == without_answers(recorded.log)


def test_frames_go_to_the_start_that_has_an_effect() -> None:
    class Single(ScriptedTransport):
        """As the contract says: does nothing if it is started."""

        def start(self, on_frame: OnFrame) -> None:
            if self._on_frame is None:
                super().start(on_frame)

    def run(program: Program) -> None:
        def create(context: TransportContext) -> Transport:
            program.made.append(Single({}, context))
            return program.made[-1]

        def take(name: str, frame: bytes, stamp_ns: int) -> None:
            program.log.append((name, frame))

        transport = program.transport(create)
        for name in ("first", "second", "third"):
            transport.start(partial(take, name))
            if name == "second":
                transport.stop()
            else:
                program.send(b"frame")
                program.spin(0.1)

    recorded = assert_replays(run)
    assert without_answers(recorded.log) == [("first", b"frame"), ("third", b"frame")]


def test_a_call_of_another_thread_spoils_the_recording() -> None:
    recorder = Recorder(ManualClock())
    program = Program(recorder)
    transport = program.transport()
    transport.start(program.take)
    on_thread(transport.stop)
    assert recorder.spoiled == ["a thread of the program's own calls stop of a transport"]


def test_the_reader_gets_the_answer_if_the_program_has_time() -> None:
    recorder = Recorder(ManualClock())
    program = Program(recorder)
    program.transport().start(program.take)
    recorder.let_go(lambda: program.send(b"good", b"bad"))
    answers = [entry[1] for entry in program.log if entry[0] == "answer"]
    assert answers == [True, False]
    # While the program is busy, the reader goes on without an answer.
    program.send(b"good")
    assert program.log[-1] == ("answer", None)


def test_a_callback_that_raises_is_logged_by_the_program(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def broken(frame: bytes, stamp_ns: int) -> None:
        raise ValueError(frame)

    def run(program: Program) -> None:
        program.transport().start(broken)
        program.send(b"one", b"two")
        program.spin(0.1)

    _, script = record(run)
    assert [entry.message for entry in caplog.records] == ["on_frame raised ValueError(b'one')"]
    caplog.clear()
    replay(run, script)
    assert [entry.message for entry in caplog.records] == ["on_frame raised ValueError(b'one')"]


def test_the_log_of_the_transport_has_throttles_of_its_own() -> None:
    recorder = Recorder(ManualClock())
    logger = RosbaseLogger("conducted", recorder.clock)
    program = Program(recorder)
    conducted_transport(
        recorder, "scripted", program.create, TransportContext(recorder.clock, logger)
    )
    inner = program.made[0].context
    assert inner.clock is recorder.clock.machine
    assert inner.logger.name == logger.name
    assert inner.logger.due("key", 5.0)
    assert logger.due("key", 5.0)
    assert not inner.logger.due("key", 5.0)


def test_health_goes_on_where_the_recording_has_none() -> None:
    def run(times: int, program: Program) -> None:
        transport = program.transport()
        transport.start(program.take)
        program.send(b"one", b"two")
        program.spin(0.5)
        program.log.extend(transport.health for _ in range(times))

    _, script = record(partial(run, 0))
    replayed, player = replay(partial(run, 1), script)
    assert player.difference is None
    health = replayed.log[-1]
    assert health.frames == 2
    assert health.received_bytes == 6
    assert health.state is TransportState.CONNECTED


class Pouring(ScriptedTransport):
    """A device that never stops sending."""

    def start(self, on_frame: OnFrame) -> None:
        super().start(on_frame)
        self.is_over = threading.Event()
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def stop(self) -> None:
        self.is_over.set()
        self.reader.join()
        super().stop()

    def _read(self) -> None:
        number = 0
        while not self.is_over.is_set():
            number += 1
            self.deliver(b"%d" % number, number)


def test_a_program_that_asks_for_other_facts_gets_what_is_known() -> None:
    def run(what: str, program: Program) -> None:
        transport = program.transport()
        transport.open()
        program.log.append(getattr(transport, what))

    _, script = record(partial(run, "is_open"))
    replayed, player = replay(partial(run, "health"), script)
    assert player.difference is None
    assert replayed.log[-1].state is TransportState.CONNECTED


def test_facts_are_not_mixed_up_after_a_difference() -> None:
    def run(has_more: bool, program: Program) -> None:
        transport = program.transport()
        transport.open()
        if has_more:
            program.executor.create_timer(S, list)
        program.spin(0.1)
        # Facts of the same entry, which is not this one any more.
        program.log.append((transport.is_open, transport.health.state))
        program.spin(0.1)

    recorded, script = record(partial(run, False))
    replayed, player = replay(partial(run, True), script)
    assert player.difference is not None
    assert replayed.log == recorded.log == [(True, TransportState.CONNECTED)]


def test_frames_that_pour_in_while_a_loop_runs_replay() -> None:
    def run(program: Program) -> None:
        transport = program.transport(lambda context: Pouring({}, context))
        transport.start(program.take)
        try:
            while len(program.log) < 200:
                program.executor.spin_until(0, lambda: False)
                program.executor.spin_once(0.001)
        finally:
            transport.stop()

    recorder = Recorder(SystemClock())
    recorded = Program(recorder)
    run(recorded)
    recorder.end(None)
    script = list(read_entries([recorder.trace.take()]))
    replayed, player = replay(run, script)
    assert player.difference is None
    # Times count from another start.
    assert [entry[:2] for entry in replayed.log] == [entry[:2] for entry in recorded.log]


def test_the_two_are_chosen_by_the_conductor() -> None:
    recorder = Recorder(ManualClock())
    assert isinstance(Program(recorder).transport(), RecordedTransport)
    recorder.end(None)
    script = list(read_entries([recorder.trace.take()]))
    player = Player(script, RunFacts(0, 0))
    assert isinstance(Program(player).transport(), ReplayedTransport)
