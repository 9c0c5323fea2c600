"""SIGINT, SIGTERM and SIGHUP: what each wish does, wherever the program is."""

import importlib
import os
import random
import signal
import sys
import time
import weakref
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import FrameType

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rosbase.runtime.stopping.signals as stopping
from rosbase import BaseManager
from rosbase.runtime.signal_masks import STOP_SIGNALS, background_thread
from rosbase.runtime.stopping import Wishes
from rosbase.runtime.stopping.interrupt import Interrupt
from support.blocking_program import (
    BLOCKING_PROGRAM,
    expect_a_clean_end,
    expect_a_named_thread,
    expect_the_end_of_an_input,
)
from support.program import running

# A campaign sets more.
RUNS = int(os.environ.get("ROSBASE_SIGNAL_RUNS", "6"))
SIGNALS = [signal.SIGINT, signal.SIGTERM]
S = 1_000_000_000
# A signal that comes so long after the answer to another one is another wish.
ANOTHER_WISH_S = 1.05

PLACES = [
    *("handle", "handshake", "callback", "on_configure"),
    *("event in handle", "join in handle", "recv in handle", "loop in handle", "spin in handle"),
    *("loop in handshake", "spin in handshake", "native in handle", "stubborn in handle"),
]


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_code_that_blocks_and_the_whole_clean_up_runs(
    place: str, signum: int, tmp_path: Path
) -> None:
    expect_a_clean_end(tmp_path, BLOCKING_PROGRAM, place, signum)


OWN_CLEAN_UP = """
import contextlib, sys, time
from rosbase import BaseHandlers, BaseManager

@contextlib.contextmanager
def motor():
    try:
        yield
    finally:
        slow("with")

def slow(what):
    try:
        int("x")
    except ValueError:
        time.sleep(1.2)
    print(what, "ends", flush=True)

class Handlers(BaseHandlers):
    def handle(self):
        print("blocking", flush=True)
        if sys.argv[1] == "with":
            with motor():
                time.sleep(60)
        try:
            time.sleep(60)
        except KeyboardInterrupt:
            if sys.argv[1] == "except":
                slow("except")
            raise
        finally:
            if sys.argv[1] == "finally":
                slow("finally")

BaseManager(handlers_class=Handlers).start_main_loop_timer()
print("returned")
"""


@pytest.mark.parametrize("place", ["finally", "with", "except"])
def test_an_own_clean_up_of_blocking_code_is_not_interrupted_again(
    place: str, tmp_path: Path
) -> None:
    with running(tmp_path, OWN_CLEAN_UP, place) as program:
        program.read_until("blocking")
        _, status, out, err = program.stop(signal.SIGINT)
    assert (status, out.splitlines(), err) == (0, [f"{place} ends", "returned"], "")


def test_a_second_request_ends_an_own_clean_up_at_once(tmp_path: Path) -> None:
    endless = OWN_CLEAN_UP.replace(
        "time.sleep(1.2)", 'print("cleaning", flush=True); time.sleep(60)'
    )
    with running(tmp_path, endless, "finally") as program:
        program.read_until("blocking")
        program.process.send_signal(signal.SIGINT)
        program.read_until("cleaning")
        time.sleep(ANOTHER_WISH_S)
        took_s, status, out, _ = program.stop(signal.SIGINT)
    assert (status, out.splitlines()) == (0, ["returned"])
    assert took_s < 3.0


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_signal_ends_an_input_on_a_terminal(signum: int, tmp_path: Path) -> None:
    expect_the_end_of_an_input(tmp_path, BLOCKING_PROGRAM, signum)


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize("place", ["constructor", "own constructor"])
def test_a_signal_in_a_constructor_undoes_it_and_ends_quietly(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, BLOCKING_PROGRAM, place) as program:
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signum)
    assert (status, err) == (0, "")
    # The camera whose own constructor blocked was never built.
    assert out.splitlines() == (["camera released"] if place == "own constructor" else [])
    assert took_s < 4.0


def test_a_signal_at_the_very_end_of_a_constructor_is_not_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put_back = stopping._Before.put_back

    def put_back_late(before: stopping._Before, **options: bool) -> None:
        signal.raise_signal(signal.SIGTERM)
        put_back(before, **options)

    monkeypatch.setattr(stopping._Before, "put_back", put_back_late)
    handler = signal.getsignal(signal.SIGTERM)
    with pytest.raises(SystemExit) as end:
        BaseManager()
    assert not end.value.code
    assert signal.getsignal(signal.SIGTERM) is handler


C_HANDLER = """
import ctypes, os, signal, sys, time
from rosbase import BaseHandlers, BaseManager

exit_at_once = ctypes.CFUNCTYPE(None, ctypes.c_int)(lambda number: os._exit(7))
signal.signal(signal.SIGTERM, signal.SIG_DFL)
ctypes.CDLL(None).signal(signal.SIGTERM, exit_at_once)


class Handlers(BaseHandlers):
    def handle(self):
        print("running", flush=True)
        self.manager.request_stop()


manager = BaseManager(handlers_class=Handlers)
if sys.argv[1] == "run":
    manager.start_main_loop_timer()
print("waiting", flush=True)
time.sleep(100)
"""


@pytest.mark.parametrize(("what", "status"), [("build", 7), ("run", -signal.SIGTERM)])
def test_a_handler_of_a_c_library_is_back_after_a_constructor_and_gone_after_a_run(
    what: str, status: int, tmp_path: Path
) -> None:
    # After a run the library may have ended with it, as rclpy has; Python's handlers are back.
    with running(tmp_path, C_HANDLER, what) as program:
        program.read_until("waiting")
        assert program.stop(signal.SIGTERM)[1] == status


@pytest.mark.parametrize("signum", [*SIGNALS, signal.SIGHUP])
def test_a_signal_between_ticks_stops_at_once_and_cleans_up_quietly(
    signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, BLOCKING_PROGRAM, "nowhere") as program:
        program.read_until("running")
        took_s, status, out, err = program.stop(signum)
    assert (status, err) == (0, "")
    assert out.splitlines() == ["arm shut down", "released", "returned"]
    assert took_s < 4.0


def test_a_second_signal_within_a_second_is_the_same_wish(tmp_path: Path) -> None:
    # From the program itself: no machine is so slow that a second passes in between.
    both = "[signal.raise_signal(number) for number in (signal.SIGTERM, signal.SIGINT)]"
    running_line, waiting_line = 'print("running", flush=True)', "time.sleep(1.5)"
    source = BLOCKING_PROGRAM
    for line, more in ((running_line, both), (waiting_line, 'print("waited", flush=True)')):
        assert source.count(line) == 1
        source = source.replace(line, f"{line}; {more}")
    with running(tmp_path, source, "on_deactivate") as program:
        status, out, err = program.end()
    assert (status, err) == (0, "")
    assert out.splitlines()[-4:] == ["waited", "arm shut down", "released", "returned"]


def test_the_second_wish_ends_only_the_step_of_the_clean_up_that_blocks(tmp_path: Path) -> None:
    with running(tmp_path, BLOCKING_PROGRAM, "release") as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGINT)
        program.read_until("blocking")
        time.sleep(ANOTHER_WISH_S)
        assert program.process.poll() is None
        took_s, status, out, err = program.stop(signal.SIGINT)
    assert status == 0
    assert out.splitlines() == ["returned"]
    assert "release_resources was interrupted by a signal" in err
    assert "Traceback" not in err
    assert took_s < 4.0


def test_the_second_wish_raises_at_once(tmp_path: Path) -> None:
    with running(tmp_path, BLOCKING_PROGRAM, "stubborn in handle") as program:
        program.read_until("blocking")
        program.process.send_signal(signal.SIGINT)
        # That is after half a second; it blocks again.
        program.read_until("caught")
        time.sleep(ANOTHER_WISH_S)
        took_s, status, out, _ = program.stop(signal.SIGINT)
    assert status == 0
    assert out.splitlines()[-3:] == ["arm shut down", "released", "returned"]
    assert took_s < 4.0


def test_the_third_wish_ends_the_process(tmp_path: Path) -> None:
    source = BLOCKING_PROGRAM.replace("        time.sleep(100)\n\n\nclass Camera", STUBBORN)
    with running(tmp_path, source, "release") as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGTERM)
        for answer in ("blocking", "caught"):
            program.read_until(answer)
            time.sleep(ANOTHER_WISH_S)
            assert program.process.poll() is None
            program.process.send_signal(signal.SIGTERM)
        status, out, _ = program.end()
    assert status == 128 + signal.SIGTERM
    assert "returned" not in out


STUBBORN = """        while True:
            try:
                time.sleep(100)
            except BaseException:
                print("caught", flush=True)


class Camera"""


def test_signals_are_ignored_for_a_second_after_the_end_and_then_are_as_before(
    tmp_path: Path,
) -> None:
    with running(tmp_path, BLOCKING_PROGRAM, "after") as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGINT)
        program.read_until("still there")
        time.sleep(ANOTHER_WISH_S)
        _, status, _, err = program.stop(signal.SIGINT)
    assert status == -signal.SIGINT, "Python ends of a KeyboardInterrupt by that signal"
    assert "KeyboardInterrupt" in err


def test_a_signal_while_python_ends_after_a_signal_changes_nothing(tmp_path: Path) -> None:
    source = "import atexit, time\natexit.register(time.sleep, 0.5)\n" + BLOCKING_PROGRAM
    with running(tmp_path, source, "nowhere") as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGTERM)
        program.read_until("returned")
        time.sleep(0.1)
        _, status, _, err = program.stop(signal.SIGTERM)
    assert (status, err) == (0, "")


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_thread_that_never_ends_is_named_and_the_manager_returns(
    signum: int, tmp_path: Path
) -> None:
    expect_a_named_thread(tmp_path, BLOCKING_PROGRAM, signum)


@pytest.mark.parametrize("number", range(RUNS))
def test_signals_at_random_moments_end_by_the_rules(number: int, tmp_path: Path) -> None:
    rng = random.Random(number if RUNS > 6 else None)
    place = rng.choice(["nowhere", "handle", "release", "on_deactivate", "handshake", "callback"])
    gaps_s = [rng.choice([rng.uniform(0.001, 0.3), rng.uniform(0.001, 2.0)]) for _ in range(2)]
    with running(tmp_path, BLOCKING_PROGRAM, place, "with a child") as program:
        first = "running" if place in ("nowhere", "release", "on_deactivate") else "blocking"
        program.read_until(first)
        sent: list[float] = []
        for gap_s in [0.0, *gaps_s[: rng.choice([1, 2])]]:
            time.sleep(gap_s)
            if program.process.poll() is not None:
                break
            sent.append(time.monotonic())
            # As systemd, or a terminal, which know nothing of who is whose child.
            members = program.family() if rng.random() < 0.5 else [program.process.pid]
            signum = rng.choice(SIGNALS)
            for pid in members:
                with suppress(ProcessLookupError):
                    os.kill(pid, signum)
        if place == "release" and program.process.poll() is None:
            # This one ends by nothing else.
            for _ in range(6):
                time.sleep(max(0.0, sent[-1] + 1.3 - time.monotonic()))
                if program.process.poll() is None:
                    sent.append(time.monotonic())
                    program.process.send_signal(signal.SIGINT)
        status, out, err = program.end()
        assert not program.family(), (place, gaps_s)
    assert err.count("child: begun") <= 1, "it was started again"
    assert "Traceback" not in err, (place, gaps_s)
    if status == 0:
        assert out.splitlines()[-1] == "returned", (place, gaps_s)
        assert "arm shut down" in out
    else:
        assert status in {128 + number for number in SIGNALS}, (place, gaps_s)
        # A signal may arrive a little later than it was sent, or sooner than the one before did.
        wishes = Wishes()
        counted = [wishes.add(int(1.1 * at_s * S)) for at_s in sent]
        assert sum(counted) >= 3, (place, gaps_s, sent)


def drop_from_a_set() -> None:
    kept = weakref.WeakSet([Interrupt(KeyboardInterrupt)])
    assert not kept


def drop_a_value() -> None:
    kept = weakref.WeakValueDictionary({1: Interrupt(KeyboardInterrupt)})
    assert not kept


def drop_a_key() -> None:
    kept = weakref.WeakKeyDictionary({Interrupt(KeyboardInterrupt): 1})
    assert not kept


def import_anew() -> None:
    sys.modules.pop("colorsys", None)
    importlib.import_module("colorsys")


@pytest.mark.parametrize("drop", [drop_from_a_set, drop_a_value, drop_a_key, import_anew])
def test_nothing_is_raised_where_python_would_print_it_and_go_on(drop: Callable[[], None]) -> None:
    interrupt = Interrupt(lambda frame: KeyboardInterrupt())
    interrupt._due_ns = 1
    callbacks, raised = [], []

    def look(frame: FrameType, event: str, argument: object) -> None:
        if frame.f_code.co_name in ("cb", "remove", "_remove"):
            callbacks.append(frame.f_code)
            try:
                interrupt.raise_in(frame)
            except KeyboardInterrupt:
                raised.append(frame.f_code)

    before = sys.gettrace()
    sys.settrace(look)
    try:
        drop()
    finally:
        sys.settrace(before)
    assert callbacks
    assert not raised
    with pytest.raises(KeyboardInterrupt):
        interrupt.raise_in(sys._getframe())


@given(st.lists(st.integers(0, 3 * S), min_size=1))
def test_wishes_are_at_least_a_second_apart_and_none_is_missed(gaps_ns: list[int]) -> None:
    wishes, now_ns = Wishes(), 5
    counted: list[int] = []
    for gap_ns in gaps_ns:
        now_ns += gap_ns
        before = wishes.count
        is_wish = wishes.add(now_ns)
        assert is_wish is (wishes.count == before + 1)
        assert is_wish is (not counted or now_ns - counted[-1] >= S)
        if is_wish:
            counted.append(now_ns)


def test_threads_of_ours_do_not_receive_the_signals_of_the_main_thread() -> None:
    look = partial(signal.pthread_sigmask, signal.SIG_BLOCK, ())
    seen: list[set[int]] = []
    thread = background_thread(lambda: seen.append(look()), "x")
    thread.start()
    thread.join(10)
    assert set(STOP_SIGNALS) <= seen[0]
    assert not set(STOP_SIGNALS) & look()


def test_no_thread_of_ours_is_started_in_another_way() -> None:
    packages = Path(__file__).parents[2] / "packages"
    found = [
        file.name
        for file in packages.glob("*/src/**/*.py")
        if "threading.Thread(target" in file.read_text() and "testing" not in file.parts
    ]
    assert found == ["signal_masks.py"]
