"""Virtual time: as fast as the machine can, and the same every time."""

import os
import signal
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.testing import ManualClock, virtual_backend
from support import hour
from support.processes import state_of
from support.program import running
from support.waiting import wait_until


@pytest.mark.once
@pytest.mark.timeout(180)
def test_an_hour_at_200_hz_takes_seconds_and_leaves_the_same_trace_twice() -> None:
    # Side by side, and with different hash seeds: neither may matter.
    path = str(Path(hour.__file__).parents[1])
    with ExitStack() as stack:
        runs = []
        for seed in ("1", "2"):
            run = subprocess.Popen(
                [sys.executable, hour.__file__],
                env=os.environ | {"PYTHONPATH": path, "PYTHONHASHSEED": seed},
                stdout=subprocess.PIPE,
                text=True,
            )
            runs.append(stack.enter_context(run))
            stack.callback(run.kill)
        traces = [run.communicate(timeout=170)[0].splitlines() for run in runs]
    assert traces[0] == traces[1]
    assert traces[0][0] == "ticks 720000 skipped 0"
    assert traces[0][1] == "seconds 3599.995 period_ns 5000000"
    assert int(traces[0][2].split()[1]) > 7_200 + 500


class Ticker(BaseNode):
    """Notes when its timer fires."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.fired: list[int] = []
        self.create_timer(0.03, lambda: self.fired.append(self.timestamp))


def test_timers_and_ticks_fall_in_the_same_order_every_time() -> None:
    class Stop(BaseHandlers):
        def handle(self) -> None:
            if self.timestamp == 9:
                self.manager.request_stop()

    traces = []
    for _ in range(3):
        manager = BaseManager(
            nodes_dict={"ticker": Ticker},
            handlers_class=Stop,
            node_freq_hz=100,
            backend=virtual_backend(),
        )
        manager.start_main_loop_timer()
        traces.append(manager.nodes["ticker"].fired)
    # Due at 30, 60 and 90 ms; the tick of the same instant goes first, and the last one stops.
    assert traces == [[4, 7]] * 3


def test_a_lone_node_lives_in_virtual_time_too() -> None:
    backend = virtual_backend()
    node = Ticker(backend=backend)
    node.create_timer(3600.01, node._request_stop)
    node.start_spin_standalone()
    assert len(node.fired) == 120_000
    assert backend.clock.monotonic_ns() == 3_600_010_000_000


def test_time_goes_on_by_what_a_callback_takes() -> None:
    clock = ManualClock()
    backend = virtual_backend(clock)
    starts: list[int] = []

    def slow() -> None:
        starts.append(clock.elapsed_ns // 1_000_000)
        clock.advance(0.025)

    backend.create_timer(0.01, slow)
    backend.spin_until(100_000_000, lambda: False)
    assert starts == [10, 35, 60, 85]


def test_a_wait_that_somebody_ends_takes_no_time() -> None:
    clock, lock = ManualClock(), threading.Lock()
    wait = clock.waiter(lock)
    assert wait(5.0)
    assert clock.elapsed_ns == 0
    assert not wait(5.0)
    assert clock.elapsed_ns == 5 * 10**9


def test_time_is_not_turned_back() -> None:
    with pytest.raises(ValueError, match=r"turned back by 1 s"):
        ManualClock().advance(-1.0)


def test_parameters_of_a_test_win_over_defaults() -> None:
    node = Ticker(backend=virtual_backend(rate=7))
    assert node.declare_parameter("rate", 5).value == 7
    node.destroy_node()


@pytest.mark.parametrize(("step_s", "text"), [(3600, "forward by 3600.0"), (-3600, "back by 3600")])
def test_a_set_system_clock_changes_stamps_only_and_is_logged(
    caplog: pytest.LogCaptureFixture, step_s: int, text: str
) -> None:
    clock = ManualClock()

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            if self.timestamp == 300:
                clock.date_ns += step_s * 10**9
            if self.timestamp == 999:
                self.manager.request_stop()

    manager = BaseManager(handlers_class=Handlers, backend=virtual_backend(clock))
    manager.start_main_loop_timer()
    assert (manager.timestamp, manager.loop_stats.overruns) == (1000, 0)
    assert manager.loop_stats.period.maximum == 5_000_000
    assert [m for m in caplog.messages if text in m] == caplog.messages[-1:]


APP = """
import os, signal, time
from rosbase import BaseHandlers, BaseManager

class Handlers(BaseHandlers):
    starts = []
    def handle(self):
        self.starts.append(time.monotonic())
        if self.timestamp == 5:
            os.kill(os.getpid(), signal.SIGSTOP)
        if self.timestamp == 100:
            self.manager.request_stop()

manager = BaseManager(handlers_class=Handlers, node_freq_hz=100)
manager.start_main_loop_timer()
starts = Handlers.starts
gap = max(range(1, len(starts)), key=lambda n: starts[n] - starts[n - 1])
print(starts[gap] - starts[gap - 1] > 0.3, manager.loop_stats.overruns >= 29)
# Forty ticks at once would be the burst; the grid has ten in the next tenth of a second.
print(sum(0 <= start - starts[gap] <= 0.1 for start in starts) <= 13)
"""


def test_a_program_that_was_stopped_goes_on_without_a_burst(tmp_path: Path) -> None:
    with running(tmp_path, APP) as program:
        wait_until(lambda: state_of(program.process.pid) == "T", "its rest")
        # The length of the pause is what is tested.
        threading.Event().wait(0.4)
        program.process.send_signal(signal.SIGCONT)
        assert program.end() == (0, "True True\nTrue\n", "")
