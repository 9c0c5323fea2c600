"""A replay: the program runs what the script says, until it does something else."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from attrs import evolve

from rosbase.clock import Clock
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying import virtual_clock
from rosbase.entries.replaying.inputs import Input
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, Notes, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.errors import DeviceNotFoundError
from rosbase.runtime.executor import Executor
from rosbase.testing import ManualClock

S = 1_000_000_000
MS = S // 1000
Log = list[Any]


class Program:
    """A program of a test, which is recorded and then replayed."""

    def __init__(self, conductor: Conductor) -> None:
        self.conductor = conductor
        self.clock: Clock = conductor.clock
        self.executor: Executor = conductor.make_executor()
        self.log: Log = []
        self.stops: list[bool] = []
        conductor.register(Kind.STOP, lambda _: self.stops.append(True))
        self.executor.begin(lambda: self.stops)

    def note(self, text: str) -> None:
        self.log.append((text, self.clock.monotonic_ns(), self.clock.now_ns()))

    def spin(self, seconds: float) -> None:
        """Spin as the handshake does, with a deadline on the program's clock."""
        deadline_ns = self.clock.monotonic_ns() + int(seconds * S)
        self.executor.spin_until(deadline_ns, lambda: self.stops)

    def outside(self, function: Callable[[], object]) -> None:
        """Call something on another thread, now."""
        thread = threading.Thread(target=function, name="worker")
        thread.start()
        thread.join()


Run = Callable[[Program], object]


def record(run: Run) -> tuple[Log, list[Entry]]:
    recorder = Recorder(ManualClock())
    program = Program(recorder)
    run(program)
    recorder.end(None)
    return program.log, list(read_entries([recorder.trace.take()]))


FACTS = RunFacts(ManualClock().now_ns(), 0)


def replay(run: Run, script: list[Entry], **options: Any) -> tuple[Log, Player]:
    player = Player(script, FACTS, **options)
    program = Program(player)
    run(program)
    player.end(None)
    return program.log, player


def recorded_again(run: Run) -> list[Entry]:
    return record(run)[1]


def timers(program: Program) -> None:
    def slow() -> None:
        program.note("slow")
        advance(program, 0.35)
        program.executor.call_soon(partial(program.note, "after slow"))

    def reset() -> None:
        program.note("reset")
        watchdog.reset()
        program.executor.call_urgently(partial(program.note, "urgent"))

    watchdog = program.executor.create_timer(S, partial(program.note, "watchdog"))
    program.executor.create_timer(S // 10, partial(program.note, "tenth"))
    program.executor.create_timer(S // 3, slow)
    resetter = program.executor.create_timer(S // 2, reset)
    for _ in range(5):
        program.spin(0.25)
        program.executor.call_soon(partial(program.note, "call"))
    program.log.append(program.executor.spin_once(0.01))
    program.executor.wait(lambda: len(program.log) > 18, program.clock.monotonic_ns() + S)
    resetter.destroy()
    program.spin(3)


def advance(program: Program, seconds: float) -> None:
    """Let a callback take time, where time is the test's."""
    if isinstance(program.conductor, Recorder):
        program.clock.advance(seconds)  # type: ignore[attr-defined]  # of the clock that it reads


def test_a_replay_runs_the_same_at_the_same_times() -> None:
    recorded, script = record(timers)
    assert len(recorded) > 30
    replayed, player = replay(timers, script)
    assert replayed == recorded
    assert player.difference is None
    assert not player.is_free


def test_readings_come_back_although_the_replay_is_faster() -> None:
    def measure(program: Program) -> None:
        begin_ns = program.clock.monotonic_ns()
        advance(program, 1.25)
        program.log.append(program.clock.monotonic_ns() - begin_ns)
        program.clock.sleep(2.0)
        program.note(str(program.clock.now()))
        program.log.append(program.clock.suspended_ns())

    recorded, script = record(measure)
    assert recorded[0] == int(1.25 * S)
    assert replay(measure, script)[0] == recorded


def test_a_program_that_reads_the_clock_more_often_still_follows() -> None:
    def read(times: int, program: Program) -> None:
        program.executor.call_soon(partial(reads, times, program))
        program.spin(1.0)

    def reads(times: int, program: Program) -> None:
        advance(program, 0.5)
        for _ in range(times):
            program.note("read")

    _, script = record(partial(read, 2))
    log, player = replay(partial(read, 3), script)
    assert player.difference is None
    assert log[2] == log[1]


def frames(program: Program) -> None:
    """Frames that another thread brings, and a call in one of them."""

    def take(payload: bytes) -> None:
        program.note(payload.decode())
        program.executor.call_soon(partial(program.note, f"after {payload.decode()}"))

    number = program.conductor.number(
        Numbered.TRANSPORT, "device", lambda entry: take(entry.payload)
    )

    def send(text: bytes) -> None:
        program.conductor.come_in(Kind.FRAME, (number, 7), text, partial(take, text))

    for text in (b"one", b"two", b"three"):
        program.outside(partial(send, text))
        program.spin(0.5)


def test_what_came_from_outside_comes_from_the_script() -> None:
    recorded, script = record(frames)
    assert [entry[0] for entry in recorded[:2]] == ["one", "after one"]
    replayed, player = replay(frames, script)
    assert replayed == recorded
    assert player.difference is None


def sections(program: Program) -> None:
    def take(payload: bytes) -> None:
        program.note(payload.decode())

    number = program.conductor.number(
        Numbered.TRANSPORT, "device", lambda entry: take(entry.payload)
    )

    def call(op: str) -> Any:
        def now() -> Any:
            program.outside(
                lambda: program.conductor.come_in(
                    Kind.FRAME, (number, 7), b"in", lambda: take(b"in")
                )
            )
            if op == "open":
                raise DeviceNotFoundError("/dev/ttyUSB7 is not there")
            return {"result": op}

        return program.conductor.section(number, op, now)

    program.note(str(call("create")))
    try:
        call("open")
    except DeviceNotFoundError as error:
        program.note(str(error))
    program.log.append(program.conductor.fact(lambda: ["fact", 1]))


def test_calls_of_a_transport_return_and_raise_what_they_did() -> None:
    recorded, script = record(sections)
    assert [entry[0] for entry in recorded] == [
        *("in", "{'result': 'create'}", "in", "/dev/ttyUSB7 is not there", "fact")
    ]
    assert replay(sections, script)[0] == recorded


def test_a_replay_makes_no_call_of_a_transport() -> None:
    calls: list[int] = []

    def run(program: Program) -> None:
        program.conductor.section(0, "stop", lambda: calls.append(1))
        program.conductor.aside(lambda: calls.append(1))

    _, script = record(run)
    assert len(calls) == 2
    replay(run, script)
    assert len(calls) == 2


def posts(program: Program) -> None:
    program.outside(lambda: program.executor.call_soon(partial(program.note, "posted")))
    program.spin(0.1)
    program.outside(lambda: program.executor.call_urgently(partial(program.note, "urgent")))
    program.spin(0.1)


def test_calls_of_a_thread_of_the_user_come_when_they_came() -> None:
    recorded, script = record(posts)
    assert [entry[0] for entry in recorded] == ["posted", "urgent"]
    replayed, player = replay(posts, script)
    assert replayed == recorded
    assert player.difference is None


def operated(program: Program) -> None:
    timer = program.executor.create_timer(S, partial(program.note, "timer"))
    program.outside(timer.cancel)
    program.spin(1.5)
    program.outside(timer.reset)
    program.spin(1.5)
    program.outside(timer.destroy)
    program.spin(1.5)


def test_timers_that_another_thread_operates_run_as_they_did() -> None:
    recorded, script = record(operated)
    assert len(recorded) == 1
    assert replay(operated, script)[0] == recorded


def stopped(program: Program) -> None:
    program.executor.create_timer(S, partial(program.note, "timer"))
    program.executor.create_timer(
        int(3.5 * S),
        lambda: program.outside(
            lambda: program.executor.stop_soon(lambda: program.stops.append(True))
        ),
    )
    while not program.stops:
        program.spin(1.0)
    program.note("clean-up")
    program.spin(1.0)


def test_a_stop_comes_where_it_came() -> None:
    recorded, script = record(stopped)
    replayed, player = replay(stopped, script)
    assert replayed == recorded
    assert player.difference is None


# Differences.


def ticking(period_ns: int, name: str, program: Program) -> None:
    def tick() -> None:
        program.note(name)

    program.executor.create_timer(period_ns, tick)
    program.executor.create_timer(S, partial(program.note, "second"))
    while not program.stops and len(program.log) < 100:
        program.spin(1.0)
        if program.log[-1][1] >= 3 * S:
            break


def test_a_timer_that_is_not_there_is_a_difference() -> None:
    def run(program: Program, *, has_timer: bool) -> None:
        timer = program.executor.create_timer(S // 2, partial(program.note, "timer"))
        if not has_timer:
            timer.cancel()
        program.spin(1.2)

    _, script = record(partial(run, has_timer=True))
    _, player = replay(partial(run, has_timer=False), script)
    assert player.difference is not None
    assert player.difference.what == (
        "this timer does not run; in the recording: timer Program.note (00:00.500)"
    )


def test_a_timer_with_another_period_is_a_difference_and_runs_with_it() -> None:
    def run(period_ns: int, program: Program) -> None:
        program.executor.create_timer(period_ns, partial(program.note, "timer"))
        program.spin(1.2)

    _, script = record(partial(run, S // 2))
    heard, player = replay(partial(run, S // 4), script)
    assert player.difference is not None
    assert player.difference.what == ("timer Program.note has period 0.25 s, recorded 0.5 s")
    assert len(heard) == 4
    # Older recordings have no periods.
    without = [evolve(entry, notes=without_periods(entry.notes)) for entry in script]
    assert replay(partial(run, S // 4), without)[1].difference is None


def without_periods(notes: Notes) -> Notes:
    found = Notes()
    found.created = notes.created
    return found


def test_something_created_in_addition_is_a_difference() -> None:
    def run(names: list[str], program: Program) -> None:
        for name in names:
            program.conductor.number(Numbered.PUBLISHER, name, lambda _: None)
        program.spin(0.1)

    script = recorded_again(partial(run, ["/a"]))
    _, player = replay(partial(run, ["/a", "/b"]), script)
    assert player.difference is not None
    assert "creates a publisher: /b" in player.difference.what
    _, player = replay(partial(run, []), script)
    assert player.difference is not None
    assert "has not created a publisher: /a" in player.difference.what
    assert replay(partial(run, ["/a"]), script)[1].difference is None


def test_a_call_that_is_not_made_is_a_difference_with_the_entries_before() -> None:
    def run(calls: int, program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        program.spin(1.5)
        for _ in range(calls):
            program.executor.call_soon(partial(program.note, "call"))
        program.spin(1.0)

    script = recorded_again(partial(run, 2))
    _, player = replay(partial(run, 1), script)
    assert str(player.difference) == (
        "first difference at 00:01.500, entry 3 (tick 0): no call is left; "
        "in the recording: a call (00:01.500)\n"
        "before: a call (00:01.500), the end of a wait (00:01.500), "
        "timer Program.note (00:01.000), the construction (00:00.000)"
    )


def test_after_a_difference_timers_run_in_virtual_time_and_inputs_at_theirs() -> None:
    def run(extra: str, program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        number = program.conductor.number(
            Numbered.TRANSPORT, "device", lambda entry: program.note(entry.payload.decode())
        )
        program.spin(1.5)
        if extra:
            program.executor.create_timer(S // 2, partial(program.note, extra))
        for text in (b"at 1.5", b"at 2.0"):
            program.outside(
                partial(program.conductor.come_in, Kind.FRAME, (number, 0), text, lambda: None)
            )
            program.spin(0.5)
        program.spin(1.2)

    script = recorded_again(partial(run, ""))
    log, player = replay(partial(run, "half"), script)
    assert player.difference is not None
    assert [(name, mono_ns // MS) for name, mono_ns, _ in log] == [
        ("timer", 1000),
        ("at 1.5", 1500),
        # A timer of the same instant is first.
        ("timer", 2000),
        ("half", 2000),
        ("at 2.0", 2000),
        ("half", 2500),
        ("timer", 3000),
        ("half", 3000),
        ("half", 3500),
    ]


def test_at_the_end_of_a_script_that_was_cut_the_program_is_asked_to_stop() -> None:
    def run(program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        while not program.stops and len(program.log) < 10:
            program.spin(0.7)

    recorded, script = record(run)
    log, player = replay(run, script[:9])
    assert player.difference is None
    assert player.is_free
    assert log == recorded[: len(log)]
    assert 2 < len(log) < 6


def test_a_replay_ends_where_the_recording_was_spoiled() -> None:
    def run(program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        program.spin(1.5)
        program.conductor.spoil("for a test")
        while not program.stops and len(program.log) < 10:
            program.spin(1.0)

    recorded, script = record(run)
    log, player = replay(run, script)
    assert player.spoiled == "for a test"
    assert player.difference is None
    assert log == recorded[: len(log)]
    assert len(log) < len(recorded)


def test_a_program_that_ends_early_is_a_difference() -> None:
    def run(spins: int, program: Program) -> None:
        for _ in range(spins):
            program.spin(0.1)

    script = recorded_again(partial(run, 3))
    _, player = replay(partial(run, 2), script)
    assert player.difference is not None
    assert player.difference.what == (
        "the program ends at 00:00.200, and the recording goes on to 00:00.300"
    )
    assert player.last.kind is Kind.END


def test_a_signal_ends_a_replay_without_a_difference() -> None:
    def run(program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        if isinstance(program.conductor, Player):
            interrupt = partial(program.stops.append, True)
            program.executor.in_signal(partial(program.executor.stop_soon, interrupt))
        while not program.stops and len(program.log) < 10:
            program.spin(1.0)

    _, script = record(run)
    log, player = replay(run, script)
    assert log == []
    assert player.was_interrupted
    assert player.difference is None


def test_inputs_without_a_script_come_at_their_times_and_then_a_stop() -> None:
    log: Log = []

    def run(program: Program) -> None:
        program.executor.create_timer(S, partial(program.note, "timer"))
        while not program.stops:
            program.spin(10.0)
        log.extend(program.log)

    player = Player([], FACTS, inputs=[Input(S * n // 2, partial(log.append, n)) for n in (1, 5)])
    program = Program(player)
    run(program)
    player.end(None)
    assert log[:2] == [1, 5]
    assert [name for name, _, _ in program.log] == ["timer", "timer"]
    assert player.difference is None


@pytest.mark.parametrize("seconds", [0.0, 5.0])
def test_a_loop_that_waits_by_reading_the_clock_does_not_hang(seconds: float) -> None:
    def run(wait_s: float, program: Program) -> None:
        end_ns = program.clock.monotonic_ns() + int(wait_s * S)
        while program.clock.monotonic_ns() < end_ns:
            advance(program, 1.0)

    script = recorded_again(partial(run, seconds))
    assert replay(partial(run, seconds), script)[1].difference is None
    if seconds:
        with pytest.raises(RuntimeError, match="stands still"):
            replay(partial(run, seconds + 1), script)


def test_a_loop_that_spins_for_no_time_does_not_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(virtual_clock, "_FOR_EVER", 100)

    def run(program: Program) -> None:
        for _ in range(1000):
            program.executor.spin_once(0.0)

    with pytest.raises(RuntimeError, match="stands still"):
        replay(run, [], inputs=[Input(S, print)])
