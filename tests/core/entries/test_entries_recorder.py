"""The recorder: one thread at a time runs the program, and everything that runs is noted."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import pytest

from rosbase import SystemClock
from rosbase.entries.kinds import Kind, TimerOp
from rosbase.entries.recorder import Recorder
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import EndFacts
from rosbase.errors import DeviceNotFoundError
from rosbase.runtime.executor import Executor
from rosbase.testing import ManualClock
from support.waiting import wait_until

S = 1_000_000_000
SETUP = {Kind.BEGIN, Kind.RETURN, Kind.END}


class Rig:
    """A recorder whose program is this test."""

    def __init__(self, clock: ManualClock | SystemClock) -> None:
        self.recorder = Recorder(clock)
        self.executor = self.recorder.make_executor()
        self.executor.begin(lambda: False)

    def spin(self, seconds: float, stopping: Callable[[], object] = lambda: False) -> None:
        now_ns = self.recorder.clock.machine.monotonic_ns()
        self.executor.spin_until(now_ns + int(seconds * S), stopping)

    def entries(self) -> list[Entry]:
        self.recorder.end(None)
        return list(read_entries([self.recorder.trace.take()]))

    def kinds(self) -> list[Kind]:
        return [entry.kind for entry in self.entries() if entry.kind not in SETUP]


@pytest.fixture
def virtual() -> Rig:
    return Rig(ManualClock())


@pytest.fixture
def real() -> Iterator[Rig]:
    rig = Rig(SystemClock())
    yield rig
    rig.recorder.end(None)


@contextmanager
def stopping_on_a_signal(rig: Rig) -> Iterator[list[int]]:
    """Have SIGALRM ask for the stop, as rosbase's handlers do."""
    stops: list[int] = []

    def stop() -> None:
        stops.append(1)
        rig.executor.call_soon(list)

    def handle(*_: object) -> None:
        rig.executor.in_signal(lambda: rig.executor.stop_soon(stop))

    before = signal.signal(signal.SIGALRM, handle)
    try:
        yield stops
    finally:
        signal.signal(signal.SIGALRM, before)


def on_thread(function: Callable[[], object]) -> None:
    thread = threading.Thread(target=function, name="worker")
    thread.start()
    thread.join()


def play(executor: Executor, clock: ManualClock) -> list[tuple[int, str]]:
    """A program with timers, calls and time that passes; return what ran when."""
    ran: list[tuple[int, str]] = []

    def note(text: str) -> None:
        ran.append((clock.elapsed_ns, text))

    def slow() -> None:
        note("slow")
        clock.advance(0.35)
        executor.call_soon(partial(note, "after slow"))

    def reset() -> None:
        note("reset")
        watchdog.reset()
        executor.call_urgently(partial(note, "urgent"))

    watchdog = executor.create_timer(S, partial(note, "watchdog"))
    executor.create_timer(S // 10, partial(note, "tenth"))
    executor.create_timer(S // 3, slow)
    executor.create_timer(S // 2, reset)
    for number in range(5):
        executor.spin_until(number * S // 4, lambda: False)
        executor.call_soon(partial(note, "call"))
    executor.spin_once(0.01)
    executor.wait(lambda: len(ran) > 18, clock.elapsed_ns + S)
    executor.spin_until(3 * S, lambda: False)
    return ran


def test_a_recorded_program_runs_as_a_plain_one() -> None:
    clock, recorded = ManualClock(), ManualClock()
    plain = play(Executor(clock), clock)
    assert len(plain) > 20
    assert play(Rig(recorded).executor, recorded) == plain
    assert recorded.elapsed_ns == clock.elapsed_ns


def test_every_call_and_timer_is_an_entry(virtual: Rig) -> None:
    virtual.executor.create_timer(S, list)
    virtual.executor.call_soon(list)
    virtual.executor.call_urgently(list)
    virtual.spin(1.5)
    entries = virtual.entries()
    assert [(entry.kind.name, *entry.ints) for entry in entries] == [
        ("BEGIN", 0),
        ("CALL", 0),
        ("CALL", 0),
        ("TIMER", S, 0),
        ("RETURN", S + S // 2, 0),
        ("END", S + S // 2),
    ]
    assert [made.text for made in entries[0].notes.created] == ["list"]


def test_readings_inside_are_noted_and_those_outside_are_not(virtual: Rig) -> None:
    clock = virtual.recorder.clock

    def read() -> None:
        clock.monotonic_ns()
        clock.advance(0.5)  # type: ignore[attr-defined]  # of the clock that it reads
        clock.now()
        clock.suspended_ns()
        on_thread(clock.monotonic_ns)

    virtual.executor.call_soon(read)
    virtual.spin(0.0)
    call = virtual.entries()[1]
    assert call.kind is Kind.CALL
    assert list(call.notes.mono) == [0]
    assert list(call.notes.date) == [S // 2]
    assert list(call.notes.slept) == [0]


def test_urgent_calls_of_a_wait_are_entries(virtual: Rig) -> None:
    answers: list[int] = []

    def ask() -> None:
        virtual.executor.call_urgently(partial(answers.append, 1))
        virtual.executor.wait(lambda: answers, S)
        answers.append(2)

    virtual.executor.call_soon(ask)
    virtual.spin(0.0)
    virtual.spin(0.0)
    assert answers == [1, 2]
    assert [entry.kind.name for entry in virtual.entries()] == [
        *("BEGIN", "CALL", "URGENT", "RETURN", "RETURN", "CALL", "RETURN", "END")
    ]


def test_what_comes_from_outside_while_the_program_sleeps_comes_in_at_once(real: Rig) -> None:
    heard: list[int] = []
    come_in = real.recorder.come_in

    def send() -> None:
        come_in(Kind.FRAME, (0, 5), b"abc", partial(heard.append, 1))
        wait_until(lambda: heard, "the frame")
        real.executor.call_soon(lambda: heard.append(2))

    thread = threading.Thread(target=send)
    thread.start()
    while len(heard) < 2:
        real.spin(0.05)
    thread.join()
    entries = real.entries()
    frame = next(entry for entry in entries if entry.kind is Kind.FRAME)
    assert (frame.ints[1:], frame.payload) == ((0, 5), b"abc")
    kinds = [entry.kind for entry in entries if entry.kind not in SETUP]
    assert kinds == [Kind.FRAME, Kind.POSTED, Kind.CALL]


def test_every_item_of_many_threads_comes_in_once_and_in_order(real: Rig) -> None:
    taken: list[tuple[int, int]] = []
    threads_count, each = 8, 500

    def take(number: int, index: int) -> None:
        assert real.recorder.is_inside
        taken.append((number, index))

    def send(number: int) -> None:
        for index in range(each):
            payload = b"%d %d" % (number, index)
            come_in = real.recorder.come_in
            come_in(Kind.PUBLISH, (number,), payload, partial(take, number, index))

    threads = [threading.Thread(target=send, args=(n,)) for n in range(threads_count)]
    for thread in threads:
        thread.start()
    while len(taken) < threads_count * each:
        real.executor.call_soon(list)
        real.spin(0.001)
    for thread in threads:
        thread.join()
    for number in range(threads_count):
        assert [index for one, index in taken if one == number] == list(range(each))
    noted = [entry.payload for entry in real.entries() if entry.kind is Kind.PUBLISH]
    assert noted == [b"%d %d" % pair for pair in taken]


def test_nothing_runs_between_the_beginning_and_the_end_of_an_entry(real: Rig) -> None:
    running: list[str] = []

    def frame() -> None:
        assert running == []

    def call() -> None:
        running.append("call")
        on_thread(partial(real.recorder.come_in, Kind.FRAME, (0, 0), b"", frame))
        running.pop()

    real.executor.call_soon(call)
    real.spin(0.0)
    assert real.recorder.has_waiting
    real.spin(0.0)
    assert real.kinds() == [Kind.CALL, Kind.FRAME]


def test_an_entry_may_join_a_thread_that_sends(real: Rig) -> None:
    heard: list[int] = []

    def send() -> None:
        for number in range(100):
            run = partial(heard.append, number)
            real.recorder.come_in(Kind.PUBLISH, (0,), b"", run)

    real.executor.call_soon(partial(on_thread, send))
    real.spin(0.0)
    assert heard == []
    real.spin(0.0)
    assert heard == list(range(100))


def test_a_section_lets_frames_in_and_can_wait_for_their_thread(real: Rig) -> None:
    is_stopping, frames = threading.Event(), []

    def read() -> None:
        while not is_stopping.is_set():
            real.recorder.come_in(Kind.FRAME, (0, 0), b"x", lambda: frames.append(1))

    reader = threading.Thread(target=read)

    def stop() -> None:
        reader.start()
        wait_until(lambda: len(frames) > 20, "frames")
        is_stopping.set()
        reader.join()

    real.executor.call_soon(lambda: real.recorder.section(3, "stop", stop))
    real.spin(0.0)
    kinds = real.kinds()
    assert kinds[-1] is Kind.SECTION
    assert kinds.index(Kind.CALL) < len(kinds) - 10
    assert kinds.count(Kind.FRAME) == len(frames)


def test_the_error_of_a_section_is_noted_and_raised(virtual: Rig) -> None:
    def fail() -> None:
        raise DeviceNotFoundError("/dev/ttyUSB7 is not there")

    with pytest.raises(DeviceNotFoundError):
        virtual.recorder.section(0, "open", fail)
    assert virtual.recorder.section(0, "create", lambda: {"a": 1}) == {"a": 1}
    failed, made, _ = virtual.entries()[1:]
    assert failed.ints[1:] == (0, 1, 0)
    assert b"DeviceNotFoundError" in failed.payload
    assert (made.ints[1:], made.payload) == ((0, 0, 1), b'{"a":1}')


def test_facts_are_noted_inside_only(virtual: Rig) -> None:
    assert virtual.recorder.fact(lambda: ["open", 3]) == ["open", 3]
    on_thread(lambda: virtual.recorder.fact(lambda: "outside"))
    assert list(virtual.entries()[0].notes.facts) == [["open", 3]]


def test_another_thread_operates_timers_when_the_turn_is_free(virtual: Rig) -> None:
    ran: list[int] = []
    timer = virtual.executor.create_timer(S, lambda: ran.append(1))
    on_thread(timer.cancel)
    assert not timer.is_canceled()
    virtual.spin(1.5)
    assert timer.is_canceled()
    on_thread(timer.reset)
    virtual.spin(1.5)
    on_thread(timer.destroy)
    virtual.spin(1.5)
    ops = [entry.ints[1:] for entry in virtual.entries() if entry.kind is Kind.TIMER_OP]
    assert ops == [(0, TimerOp.CANCEL), (0, TimerOp.RESET), (0, TimerOp.DESTROY)]
    assert len(ran) == 1


def test_a_timer_of_another_thread_spoils_the_recording(virtual: Rig) -> None:
    on_thread(lambda: virtual.executor.create_timer(S, list))
    virtual.spin(0.0)
    assert virtual.recorder.spoiled == ["thread 'worker' created a timer: list"]
    assert [entry.notes.spoiled for entry in virtual.entries() if entry.notes.spoiled]


def test_a_request_to_stop_comes_in_between_entries(real: Rig) -> None:
    seen: list[int] = []
    with stopping_on_a_signal(real) as stops:

        def call() -> None:
            signal.raise_signal(signal.SIGALRM)
            seen.append(len(stops))

        real.executor.call_soon(call)
        real.spin(10.0, lambda: stops)
    assert (seen, stops) == ([0], [1])
    assert real.kinds() == [Kind.CALL, Kind.STOP, Kind.CALL]


def test_a_signal_ends_a_sleep(real: Rig) -> None:
    with stopping_on_a_signal(real) as stops:
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        real.executor.create_timer(20 * S, list)
        real.spin(30.0, lambda: stops)
    assert real.kinds() == [Kind.STOP, Kind.CALL]


def test_an_entry_from_outside_can_have_a_result(real: Rig) -> None:
    answers: list[str] = []
    enter = real.recorder.enter

    def change() -> None:
        answers.append(enter(Kind.CHANGE_STATE, (0,), b"{}", lambda: "active"))

    thread = threading.Thread(target=change)
    thread.start()
    while not answers:
        real.spin(0.01)
    thread.join()
    assert answers == ["active"]
    assert real.kinds() == [Kind.CHANGE_STATE]


def test_an_exception_of_an_item_spoils_and_is_the_senders(real: Rig) -> None:
    def fail() -> None:
        raise ValueError("no such frame")

    errors: list[str] = []

    def send() -> None:
        try:
            real.recorder.come_in(Kind.FRAME, (0, 0), b"", fail)
        except ValueError as error:
            errors.append(str(error))

    real.recorder.let_go(partial(on_thread, send))
    assert errors == ["no such frame"]
    assert real.recorder.spoiled == ["FRAME raised ValueError: no such frame"]


def test_upkeep_is_no_entry_and_lets_others_run(virtual: Rig) -> None:
    inside: list[bool] = []
    virtual.executor.call_aside(lambda: inside.append(virtual.recorder.is_inside))
    virtual.recorder.aside(lambda: inside.append(virtual.recorder.is_inside))
    virtual.spin(0.0)
    assert inside == [False, False]
    assert virtual.kinds() == []


def test_calls_of_other_threads_are_numbered_for_each_thread(virtual: Rig) -> None:
    def post() -> None:
        virtual.executor.call_soon(list)
        virtual.executor.call_soon(list)

    on_thread(post)
    on_thread(post)
    virtual.spin(0.0)
    posted = [entry.ints[1:] for entry in virtual.entries() if entry.kind is Kind.POSTED]
    assert posted == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_after_the_end_all_goes_on_without_a_recording(virtual: Rig) -> None:
    heard: list[int] = []
    virtual.recorder.end(None)
    virtual.recorder.end(None)
    on_thread(lambda: virtual.recorder.come_in(Kind.FRAME, (0, 0), b"", lambda: heard.append(1)))
    virtual.recorder.clock.monotonic_ns()
    assert heard == [1]
    entries = list(read_entries([virtual.recorder.trace.take()]))
    assert [entry.kind for entry in entries] == [Kind.BEGIN, Kind.END]


def test_a_program_that_is_given_up_on_another_thread_ends_its_recording(virtual: Rig) -> None:
    on_thread(lambda: virtual.recorder.end(None))
    assert [entry.kind for entry in read_entries([virtual.recorder.trace.take()])] == [
        *(Kind.BEGIN, Kind.END)
    ]


def test_nothing_is_recorded_in_a_forked_child(virtual: Rig) -> None:
    heard: list[int] = []
    virtual.recorder.forget()
    virtual.recorder.clock.monotonic_ns()
    virtual.recorder.come_in(Kind.FRAME, (0, 0), b"", lambda: heard.append(1))
    virtual.spin(0.0)
    assert heard == [1]
    assert list(virtual.recorder.trace.take().ints) == [Kind.BEGIN, 0]


def test_the_sink_is_told_of_the_end() -> None:
    class Sink:
        ends: list[EndFacts] = []  # noqa: RUF012 - one test

        def begin(self, *_: object) -> None:
            pass

        def close(self, end: EndFacts) -> None:
            self.ends.append(end)

    recorder = Recorder(ManualClock(), Sink())
    recorder.spoil("for a test")
    recorder.end(RuntimeError("broken"))
    assert Sink.ends == [EndFacts(2, "RuntimeError: broken", ["for a test"])]
