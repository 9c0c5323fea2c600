"""Random programs: whatever they do, the manager keeps its order."""

from functools import partial
from itertools import pairwise
from typing import Any

from attrs import frozen
from hypothesis import given
from hypothesis import strategies as st

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode, CallbackReturn, LifecycleNode
from rosbase import State as Lifecycle
from rosbase.messages import Header
from rosbase.testing import ManualClock, virtual_backend

states = st.sampled_from(["PREPARE", "RUN", "RECOVER"])
hooks = st.sampled_from(["switch", "state_handle", "handlers", "callback", "timer"])


@frozen
class Tick:
    """What a program does in one tick."""

    switch: str | None = None
    """What `get_state_switch` gives."""
    sets_state: str | None = None
    """What the handlers write into `state`."""
    sets_timestamp: int | None = None
    """What the handlers write into `timestamp`."""
    takes_s: float = 0.0
    publishes: int = 0


@frozen
class Program:
    """A whole application, as data."""

    rules: tuple[int, ...]
    """For each handshake rule, at the how-manieth asking it holds; a negative one raises before."""
    ticks: tuple[Tick, ...]
    """The program asks to stop in the last one."""
    raises: tuple[int, str] | None
    """In which tick, and in which hook, it raises."""
    broken_shutdown: frozenset[str]
    """Steps of the shutdown that raise."""


ticks = st.builds(
    Tick,
    switch=st.none() | states,
    sets_state=st.none() | states,
    sets_timestamp=st.none() | st.just(0) | st.integers(-5, 10**6),
    takes_s=st.sampled_from([0.0, 0.0, 0.001, 0.05, 0.31]),
    publishes=st.integers(0, 3),
)
programs = st.builds(
    Program,
    rules=st.lists(st.integers(-6, 6), max_size=4).map(tuple),
    ticks=st.lists(ticks, min_size=1, max_size=12).map(tuple),
    raises=st.none() | st.tuples(st.integers(0, 12), hooks),
    broken_shutdown=st.frozensets(st.sampled_from(["cleanup", "release", "destroy"])),
)


class BoomError(Exception):
    """What a program raises in a tick."""


class Recorder:
    """Runs a program and writes down what happened."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.clock = ManualClock()
        self.trace: list[Any] = []
        self.tick = -1
        self.asked = [0] * len(program.rules)
        recorder = self

        class Device(LifecycleNode):
            autostart = "activate"

            def on_deactivate(self, previous_state: Lifecycle) -> CallbackReturn:
                recorder.trace.append("deactivate")
                return CallbackReturn.SUCCESS

            def on_cleanup(self, previous_state: Lifecycle) -> CallbackReturn:
                recorder.step("cleanup")
                return CallbackReturn.SUCCESS

        class Talk(BaseNode):
            def __init__(self, manager: Any, **kwargs: Any) -> None:
                super().__init__(manager, **kwargs)
                self.sender = self.create_publisher(Header, "talk")
                self.create_subscription(Header, "talk", self.hear)
                self.create_timer(0.02, lambda: recorder.may_raise("timer"))

            def hear(self, message: Header) -> None:
                recorder.trace.append("callback")
                recorder.may_raise("callback")

        class Brain(BaseAgent):
            def reset(self) -> None: ...

        class Handlers(BaseHandlers):
            def handle(self) -> None:
                recorder.handle(self)

        class App(BaseManager):
            def get_state_switch(self) -> str | None:
                recorder.tick += 1
                recorder.trace.append(("switch", self.timestamp))
                recorder.may_raise("switch")
                return recorder.now.switch

            def state_handle(self, switch: str | None) -> None:
                recorder.trace.append(("state_handle", switch, self.state))
                recorder.may_raise("state_handle")

            def release_resources(self) -> None:
                recorder.step("release")

            def destroy_node(self) -> None:
                super().destroy_node()
                recorder.step("destroy")

        self.manager = App(
            nodes_dict={"device": Device, "talk": Talk},
            agents_dict={"brain": Brain},
            handlers_class=Handlers,
            node_freq_hz=10,
            start_state="START",
            backend=virtual_backend(self.clock),
        )
        for index in range(len(program.rules)):
            self.manager.add_handshake_rule(str(index), partial(self.ask, index))

    @property
    def now(self) -> Tick:
        return self.program.ticks[self.tick]

    def run(self) -> BaseException | None:
        try:
            self.manager.start_main_loop_timer()
        except Exception as error:
            return error
        return None

    def ask(self, index: int) -> bool:
        self.trace.append("ask")
        self.asked[index] += 1
        holds = self.asked[index] > abs(self.program.rules[index])
        if not holds and self.program.rules[index] < 0:
            raise ValueError("not yet")
        return holds

    def handle(self, handlers: BaseHandlers) -> None:
        now = self.now
        self.trace.append(("handlers", handlers.state, handlers.timestamp))
        self.clock.advance(now.takes_s)
        for _ in range(now.publishes):
            handlers.nodes["talk"].sender.publish(Header())
        if now.sets_state is not None:
            handlers.state = now.sets_state
        if now.sets_timestamp is not None:
            handlers.timestamp = now.sets_timestamp
        self.may_raise("handlers")
        if self.tick == len(self.program.ticks) - 1:
            self.manager.request_stop()

    def may_raise(self, hook: str) -> None:
        if self.program.raises == (self.tick, hook):
            raise BoomError(hook)

    def step(self, name: str) -> None:
        self.trace.append(name)
        if name in self.program.broken_shutdown:
            raise OSError(name)


def expected_ticks(program: Program) -> list[Any]:
    """What the ticks of a program that raises nothing leave behind, callbacks aside."""
    trace: list[Any] = []
    state, timestamp = "START", 0
    for tick in program.ticks:
        trace.append(("switch", timestamp))
        state = tick.switch or state
        trace.append(("state_handle", tick.switch, state))
        trace.append(("handlers", state, timestamp))
        state = tick.sets_state or state
        timestamp = (timestamp if tick.sets_timestamp is None else tick.sets_timestamp) + 1
    return trace


@given(programs)
def test_the_order_of_ticks_timestamps_and_shutdown_is_kept(program: Program) -> None:
    recorder = Recorder(program)
    error = recorder.run()
    trace = recorder.trace
    in_ticks = [entry for entry in trace if isinstance(entry, tuple)]
    expected = expected_ticks(program)

    # Ticks in order, up to where it raised; callbacks only between ticks.
    assert in_ticks == expected[: len(in_ticks)]
    if not isinstance(error, BoomError):
        assert in_ticks == expected
    for index, entry in enumerate(trace):
        if entry == "callback":
            before = trace[index - 1]
            assert before == "callback" or before[0] == "handlers"

    # The handshake comes first, and lasts until every rule has held.
    asks = trace.count("ask")
    assert trace[:asks] == ["ask"] * asks
    assert all(n > abs(rule) for n, rule in zip(recorder.asked, program.rules, strict=True))

    # The shutdown comes last, whole, and in its order.
    assert trace[-4:] == ["deactivate", "cleanup", "release", "destroy"]
    assert recorder.manager.nodes["device"].get_state() is Lifecycle.FINALIZED

    # What the ticks raised is what is raised; else the first failure of the shutdown.
    broken = [step for step in ("release", "destroy") if step in program.broken_shutdown]
    if isinstance(error, BoomError):
        assert program.raises is not None
        assert str(error) == program.raises[1]
    elif broken:
        assert isinstance(error, OSError)
        assert str(error) == broken[0]
    else:
        assert error is None


@given(st.lists(st.sampled_from([0.0, 0.01, 0.09, 0.1, 0.101, 0.25, 1.0]), max_size=20))
def test_ticks_stay_on_the_grid_whatever_the_handlers_take(durations: list[float]) -> None:
    clock = ManualClock()
    starts: list[int] = []

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            starts.append(clock.elapsed_ns)
            if self.timestamp == len(durations):
                self.manager.request_stop()
            else:
                clock.advance(durations[self.timestamp])

    manager = BaseManager(handlers_class=Handlers, node_freq_hz=10, backend=virtual_backend(clock))
    manager.start_main_loop_timer()
    period_ns = 100_000_000
    for (begin_ns, next_ns), takes_s in zip(pairwise(starts), durations, strict=True):
        end_ns = begin_ns + round(takes_s * 1e9)
        if next_ns != end_ns:
            assert next_ns % period_ns == 0, "it waited, so it is on the grid"
            assert next_ns > end_ns
        # No burst: never two ticks in one period.
        assert next_ns // period_ns > begin_ns // period_ns
    slots = starts[-1] // period_ns + 1
    assert manager.loop_stats.overruns == slots - len(starts)
