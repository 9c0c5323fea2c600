"""The handshake and the ticks, as programs see them."""

from collections.abc import Callable
from functools import partial
from itertools import groupby
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode
from rosbase.runtime.rate import Rate
from rosbase.testing import ManualClock, virtual_backend
from support.roles import StopAfter


def run(manager_class: type[BaseManager] = BaseManager, **kwargs: Any) -> BaseManager:
    """Runs it in virtual time, to its end."""
    kwargs.setdefault("backend", virtual_backend())
    manager = manager_class(**{"handlers_class": StopAfter, **kwargs})
    manager.start_main_loop_timer()
    return manager


def test_a_manager_with_nothing_in_it_ticks() -> None:
    class App(BaseManager):
        def update_timestamp(self) -> None:
            super().update_timestamp()
            if self.timestamp == 3:
                self.request_stop()

    assert run(App, handlers_class=None).timestamp == 3


def test_a_state_handle_without_an_argument_is_called_every_tick() -> None:
    called: list[int] = []

    class App(BaseManager):
        def state_handle(self) -> None:
            called.append(self.timestamp)

    run(App)
    assert called == [0, 1, 2, 3, 4]


def test_a_state_handle_with_an_argument_is_given_what_the_switch_gave_none_too() -> None:
    given: list[Any] = []

    class App(BaseManager):
        def get_state_switch(self) -> str | None:
            return {1: "RUN", 3: "REST"}.get(self.timestamp)

        def state_handle(self, switch: str | None) -> None:
            given.append((switch, self.state))

    run(App, start_state="PREPARE")
    assert given == [
        (None, "PREPARE"),
        ("RUN", "RUN"),
        (None, "RUN"),
        ("REST", "REST"),
        (None, "REST"),
    ]


def test_a_state_handle_alone_is_given_none() -> None:
    given: list[Any] = []

    class App(BaseManager):
        def state_handle(self, switch: str | None) -> None:
            given.append(switch)

    run(App)
    assert given == [None] * 5


def test_a_subclass_may_set_its_state_functions_after_the_base_is_built() -> None:
    given: list[Any] = []

    class App(BaseManager):
        def __init__(self, **kwargs: Any) -> None:
            super().__init__(**kwargs)
            self.get_state_switch = lambda: "RUN"
            self.state_handle = given.append

    assert run(App).state == "RUN"
    assert given == ["RUN"] * 5


def test_the_handlers_may_set_the_timestamp_and_restart_the_count() -> None:
    seen: list[int] = []

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            seen.append(self.timestamp)
            if len(seen) == 3:
                self.timestamp = 0
            if len(seen) == 6:
                self.manager.request_stop()

    assert run(handlers_class=Handlers).timestamp == 4
    assert seen == [0, 1, 2, 1, 2, 3]


def test_a_subclass_may_set_the_timestamp() -> None:
    class App(BaseManager):
        def state_handle(self) -> None:
            if self.timestamp == 2:
                self.timestamp = 100

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            if self.timestamp == 101:
                self.manager.request_stop()

    assert run(App, handlers_class=Handlers).timestamp == 102


def test_agents_and_nodes_see_the_timestamp_of_the_tick_and_may_decimate() -> None:
    class Slow(BaseAgent):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.ran_at: list[tuple[int, str | None, float]] = []

        def reset(self) -> None: ...

        def compute(self) -> None:
            if self.timestamp % 4 == 0:
                self.ran_at.append((self.timestamp, self.state, self.node_freq_hz))

    class Handlers(StopAfter):
        ticks = 10

        def handle(self) -> None:
            self.agents["slow"].compute()
            assert self.nodes["n"].timestamp == self.timestamp
            super().handle()

    manager = run(
        nodes_dict={"n": BaseNode},
        agents_dict={"slow": Slow},
        handlers_class=Handlers,
        start_state="go",
        node_freq_hz=20,
    )
    assert manager.agents["slow"].ran_at == [(0, "go", 20), (4, "go", 20), (8, "go", 20)]


def test_an_overriding_main_loop_counts_with_update_timestamp() -> None:
    class App(BaseManager):
        def main_loop(self) -> None:
            self.update_timestamp()
            if self.timestamp == 3:
                self.request_stop()

    class Never(BaseHandlers):
        def handle(self) -> None:
            raise AssertionError("the override decides what a tick does")

    assert run(App, handlers_class=Never).timestamp == 3


def test_start_main_loop_is_an_older_name_of_start_main_loop_timer() -> None:
    manager = BaseManager(handlers_class=StopAfter, backend=virtual_backend())
    manager.start_main_loop()
    assert manager.timestamp == 5


def busy_ticks(works_s: Callable[[int], float], ticks: int) -> list[tuple[str, float]]:
    """When ticks and the calls of a node's timer began, both due ten times a second."""
    clock = ManualClock()
    events: list[tuple[str, float]] = []

    class Busy(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_timer(0.1, self.work)

        def work(self) -> None:
            events.append(("timer", clock.elapsed_ns / 1e9))
            clock.advance(works_s(len(events)))

    class Handlers(StopAfter):
        def handle(self) -> None:
            events.append(("tick", clock.elapsed_ns / 1e9))
            super().handle()

    Handlers.ticks = ticks
    run(
        nodes_dict={"busy": Busy},
        handlers_class=Handlers,
        node_freq_hz=10,
        backend=virtual_backend(clock),
    )
    return events


def test_a_timer_of_a_node_that_is_always_late_takes_turns_with_the_ticks() -> None:
    events = busy_ticks(lambda number: 0.15, ticks=20)
    turns = [len(list(calls)) for _, calls in groupby(kind for kind, _ in events[1:])]
    # Twice only where the next tick is not due yet.
    assert max(turns) <= 2
    assert len(turns) > 25


def test_many_timers_that_are_always_late_have_one_turn_each_between_two_ticks() -> None:
    clock = ManualClock()
    events: list[str] = []

    class Busy(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            for name in "abcde":
                self.create_timer(0.1, partial(self.work, name))

        def work(self, name: str) -> None:
            events.append(name)
            clock.advance(0.3)

    class Handlers(StopAfter):
        ticks = 20

        def handle(self) -> None:
            events.append("-")
            super().handle()

    run(
        nodes_dict={"busy": Busy},
        handlers_class=Handlers,
        node_freq_hz=10,
        backend=virtual_backend(clock),
    )
    rounds = ["".join(sorted(turn)) for turn in "".join(events).split("-")]
    assert set(rounds[2:-1]) == {"abcde"}


def test_ticks_that_a_timer_of_a_node_held_up_are_never_caught_up_in_a_burst() -> None:
    events = busy_ticks(lambda number: 0.35 if number % 10 == 0 else 0.01, ticks=40)
    ticks = [at for kind, at in events if kind == "tick"]
    # A late tick keeps the phase, so the one after it comes sooner; but never two of them.
    for first, third in zip(ticks, ticks[2:], strict=False):
        assert third - first >= 0.14


def test_without_rules_the_handshake_passes_at_once() -> None:
    clock = ManualClock()
    first: list[int] = []

    class Handlers(StopAfter):
        ticks = 1

        def handle(self) -> None:
            first.append(clock.elapsed_ns)
            super().handle()

    run(handlers_class=Handlers, backend=virtual_backend(clock))
    assert first == [0]


def test_all_rules_must_hold_before_the_first_tick_and_are_asked_every_tenth_of_a_second() -> None:
    clock = ManualClock()
    asked: list[float] = []

    class App(BaseManager):
        def __init__(self, **kwargs: Any) -> None:
            super().__init__(**kwargs)
            self.add_handshake_rule("at once", lambda: True)
            self.add_handshake_rule("half a second", self.after_half_a_second)

        def after_half_a_second(self) -> bool:
            asked.append(clock.elapsed_ns / 1e9)
            return asked[-1] >= 0.45

        def main_loop(self) -> None:
            assert asked[-1] >= 0.45
            self.request_stop()

    run(App, backend=virtual_backend(clock))
    assert sorted(set(asked)) == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])


@pytest.mark.parametrize("answer", [True, None])
def test_an_overridden_handshake_waits_on_false_only(answer: bool | None) -> None:
    answers: list[bool | None] = [False, False, answer]

    class App(BaseManager):
        def handshake(self) -> bool | None:
            return answers.pop(0)

    assert run(App).timestamp == 5
    assert answers == []


@pytest.mark.parametrize(("waits_s", "lines"), [(0.5, 0), (3.0, 1), (7.0, 2)])
def test_a_handshake_that_takes_long_says_now_and_then_what_it_waits_for(
    caplog: pytest.LogCaptureFixture, waits_s: float, lines: int
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    clock = ManualClock()
    manager = BaseManager(handlers_class=StopAfter, backend=virtual_backend(clock))
    manager.add_handshake_rule("Robot", lambda: clock.elapsed_ns >= waits_s * 1e9)
    manager.add_handshake_rule("Battery", lambda: True)
    manager.start_main_loop_timer()
    assert caplog.messages == ["waiting for: Robot"] * lines


def test_a_stop_while_the_handshake_waits_ends_without_a_tick() -> None:
    class Impatient(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_timer(1.0, manager.request_stop)

    class App(BaseManager):
        def __init__(self, **kwargs: Any) -> None:
            super().__init__(**kwargs)
            self.add_handshake_rule("never", lambda: False)

    assert run(App, nodes_dict={"n": Impatient}).timestamp == 0


def test_the_frequency_is_logged_only_if_asked_for(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", logger="rosbase")
    run(node_freq_hz=1)
    assert caplog.messages == []


@pytest.mark.parametrize("frequency_hz", [0.5, 5, 200])
def test_a_step_of_the_system_clock_is_logged_once_and_changes_no_tick(
    caplog: pytest.LogCaptureFixture, frequency_hz: float
) -> None:
    clock = ManualClock()
    began: list[float] = []

    class Handlers(StopAfter):
        ticks = int(10 * frequency_hz)

        def handle(self) -> None:
            if self.timestamp == self.ticks // 2:
                clock.date_ns -= 3_600_000_000_000
            began.append(clock.elapsed_ns / 1e9)
            super().handle()

    run(handlers_class=Handlers, node_freq_hz=frequency_hz, backend=virtual_backend(clock))
    assert caplog.messages == ["the system clock was set back by 3600.0 s"]
    assert began == pytest.approx([n / frequency_hz for n in range(Handlers.ticks)])


def test_an_overriding_main_loop_has_its_frequency_logged_too(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO", logger="rosbase")

    class App(BaseManager):
        def main_loop(self) -> None:
            self.update_timestamp()
            if self.timestamp == 10:
                self.request_stop()

    run(App, node_freq_hz=4, log_freq=True)
    assert set(caplog.messages) == {"main loop: 4.0 Hz"}


@given(
    st.lists(st.integers(0, 60_000_000), min_size=1, max_size=40),
    st.sampled_from([10.0, 30.0, 200.0, 333.3, 1000.0]),
)
def test_ticks_begin_when_the_rate_says_and_count_what_it_skips(
    durations_ns: list[int], frequency_hz: float
) -> None:
    clock = ManualClock()
    began_ns: list[int] = []

    class Handlers(StopAfter):
        ticks = len(durations_ns)

        def handle(self) -> None:
            began_ns.append(clock.elapsed_ns)
            clock.elapsed_ns += durations_ns[self.timestamp]
            super().handle()

    manager = run(
        handlers_class=Handlers, node_freq_hz=frequency_hz, backend=virtual_backend(clock)
    )
    rate, now_ns, expected_ns = Rate(frequency_hz, 0), 0, []
    for duration_ns in durations_ns:
        now_ns = max(now_ns, rate.deadline_ns)
        expected_ns.append(now_ns)
        now_ns += duration_ns
        rate.advance(now_ns)
    assert began_ns == expected_ns
    assert manager.loop_stats.overruns == rate.skipped
    assert manager.loop_stats.ticks == len(durations_ns)
